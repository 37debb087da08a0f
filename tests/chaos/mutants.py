#!/usr/bin/python3
"""mutants.py PROGRAM LIST: runs random sessions with each error of LIST (plant.py) until the judge fails one, and prints a table: sessions needed,
place, what is wrong, first violation. Ends with 1 when one survives.

mutants.py PROGRAM LIST KNOWN: the same with changes to core and nodes (tests/mutants/mutate.py), --count of them drawn by --seed; those that KNOWN
(tests/mutants/known.tsv) says do no harm are not drawn. Their share is a figure, not a verdict: the judge sees what a patient would, and many a
change shows only to the unit tests (`deploy/dev cover --mutants`).

A program that crashes or hangs counts as found. --first goes on where an earlier run ended; --only takes numbers of LIST."""
import argparse
import concurrent.futures
import os
import pathlib
import random
import subprocess
import sys

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('program')
parser.add_argument('list')
parser.add_argument('known', nargs='?')
parser.add_argument('--count', type=int, default=60)
parser.add_argument('--seed', default='1')
parser.add_argument('--first', type=int, default=1, metavar='SESSION')
parser.add_argument('--sessions', type=int, default=2000, help='the last one')
parser.add_argument('--only', type=lambda text: text.split(','), metavar='N,N')
parser.add_argument('--jobs', type=int, default=os.cpu_count())
wanted = parser.parse_args()

drawn = [row.split('\t') for row in pathlib.Path(wanted.list).read_text().splitlines() if row]
if wanted.known:
    harmless = {tuple(row.split('\t')[:3]) for row in pathlib.Path(wanted.known).read_text().splitlines() if row.count('\t') == 3}
    drawn = [row for row in drawn if (row[1], row[3], row[4]) not in harmless]
    drawn = random.Random(wanted.seed).sample(drawn, min(wanted.count, len(drawn)))
if wanted.only:
    drawn = [row for row in drawn if row[0] in wanted.only]
# A session takes about 0.3 s; a mutant that makes one endless is found by this.
LIMIT_S = 60 + 2 * wanted.sessions


def run(number, first=wanted.first, last=wanted.sessions):
    try:
        result = subprocess.run([wanted.program, '--sessions', str(first), str(last)], env={**os.environ, 'HOIST_MUTANT': number}, check=False,
                                stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, errors='replace', timeout=LIMIT_S)
    except subprocess.TimeoutExpired:
        return 'hangs', ''
    if result.returncode == 0:
        return None, ''
    if result.returncode != 1:
        return 'crashes', ''
    needed, _, why = result.stdout.strip().partition('\t')
    return needed, why


if run('-1', 1, 10)[0] is not None:
    sys.exit('the unchanged program fails, too')
found = 0
print('# session\tnumber\tfile\tline\tchange\tsource\tfirst violation')
with concurrent.futures.ThreadPoolExecutor(wanted.jobs) as pool:
    for row, (needed, why) in zip(drawn, pool.map(run, [row[0] for row in drawn])):
        found += needed is not None
        print('\t'.join([needed or 'SURVIVES', row[0], row[1], row[2], row[3], row[4][:90], why]), flush=True)
print(f'# {found} of {len(drawn)} found in sessions {wanted.first} to {wanted.sessions}, {len(drawn) - found} survive')
if not wanted.known and found < len(drawn):
    sys.exit(1)
