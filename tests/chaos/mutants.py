#!/usr/bin/python3
"""mutants.py PROGRAM LIST KNOWN [--count N] [--seed TEXT] [--sessions N] [--jobs N]: draws N changes to core and nodes (tests/mutants/mutate.py) by
the seed, runs random sessions with each of them until the judge fails one, and prints a table: change, sessions needed, first violation. Changes that
KNOWN (tests/mutants/known.tsv) says to do no harm are not drawn. A program that crashes or hangs counts as found. The share is a figure, not a
verdict: the judge sees what a patient would, and many a change shows only to the unit tests (`deploy/dev cover --mutants`)."""
import argparse
import concurrent.futures
import os
import pathlib
import random
import subprocess

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('program')
parser.add_argument('list')
parser.add_argument('known')
parser.add_argument('--count', type=int, default=60)
parser.add_argument('--seed', default='1')
parser.add_argument('--sessions', type=int, default=2000)
parser.add_argument('--jobs', type=int, default=os.cpu_count())
wanted = parser.parse_args()

rows = [row.split('\t') for row in pathlib.Path(wanted.list).read_text().splitlines() if row]
harmless = {tuple(row.split('\t')[:3]) for row in pathlib.Path(wanted.known).read_text().splitlines() if row.count('\t') == 3}
rows = [row for row in rows if (row[1], row[3], row[4]) not in harmless]
drawn = random.Random(wanted.seed).sample(rows, min(wanted.count, len(rows)))
# A session takes about 0.3 s; a mutant that makes one endless is found by this.
LIMIT_S = 60 + 2 * wanted.sessions


def run(row):
    try:
        result = subprocess.run([wanted.program, '--sessions', str(wanted.sessions)], env={**os.environ, 'HOIST_MUTANT': row[0]}, check=False,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors='replace', timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return 'hangs', ''
    if result.returncode == 0:
        return None, ''
    if result.returncode != 1:
        return 'crashes', ''
    needed, _, why = result.stdout.strip().partition('\t')
    return needed, why


found = 0
print('# sessions\tfile\tline\tchange\tsource\tfirst violation')
with concurrent.futures.ThreadPoolExecutor(wanted.jobs) as pool:
    for row, (needed, why) in zip(drawn, pool.map(run, drawn)):
        found += needed is not None
        print('\t'.join([needed or 'SURVIVES', row[1], row[2], row[3], row[4][:90], why]), flush=True)
print(f'# {found} of {len(drawn)} changes found in at most {wanted.sessions} sessions (seed {wanted.seed}), {len(drawn) - found} survive')
