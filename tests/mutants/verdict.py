#!/usr/bin/python3
"""verdict.py PROGRAM LIST KNOWN [--sample N --seed TEXT] [--file PART]: runs, for each mutant of the list, those tests of PROGRAM that come by its
place, quick ones first, and names each mutant that no test notices. Exit status 1 when one of them is not in KNOWN. Tests that alone take longer
than a second are left out: a survivor would cost a minute.

KNOWN is a table, separated by tabs. A row of four: file, what changes, source line, and why the change does no harm. A row of two: a file whose
tests do not notice all yet, and how many of a hundred they notice (? not counted yet); a run of all its mutants fails below that. In every other
file each mutant must be noticed or have its row. --sample takes N mutants of those other files, drawn by the seed; --file those of files whose
name holds PART."""
import argparse
import collections
import concurrent.futures
import itertools
import os
import pathlib
import random
import subprocess
import sys
import tempfile

parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
parser.add_argument('program')
parser.add_argument('list')
parser.add_argument('known')
parser.add_argument('--sample', type=int)
parser.add_argument('--seed', default='1')
parser.add_argument('--file', default='')
parser.add_argument('--show', action='store_true', help='name all that are not noticed, and the share of each file')
wanted = parser.parse_args()

Mutant = collections.namedtuple('Mutant', 'number file line what source')
mutants = [Mutant(*row.split('\t')) for row in pathlib.Path(wanted.list).read_text().splitlines() if row]
mutants = [mutant for mutant in mutants if wanted.file in mutant.file]


def key(mutant):
    return mutant.file, mutant.what, mutant.source


harmless, floors = set(), {}
for row in pathlib.Path(wanted.known).read_text().splitlines():
    if row and not row.startswith('#'):
        file, *rest = row.split('\t')
        if len(rest) == 1:
            floors[file] = 0 if rest[0] == '?' else int(rest[0])
        else:
            harmless.add((file, rest[0], rest[1]))
whole = len(mutants)
# A row whose change is gone from the source would hide what comes to stand there.
files, changes = {mutant.file for mutant in mutants}, {key(mutant) for mutant in mutants}
gone = sorted(row for row in harmless - changes if row[0] in files)
for row in gone:
    print('NO SUCH CHANGE: ' + '\t'.join(row), flush=True)
if wanted.sample is not None:
    mutants = [mutant for mutant in mutants if mutant.file not in floors]
    mutants = random.Random(wanted.seed).sample(mutants, min(wanted.sample, len(mutants)))

options = ['--gtest_brief=1', '--gtest_fail_fast', '--gtest_catch_exceptions=0']
QUICK_MS, LONGEST_MS = 30, 1000
# All tests together take a minute or two.
WHOLE_LIMIT_S = 900


def run(environment, limit_s, *more):
    try:
        return subprocess.run([wanted.program, *options, *more], env={**os.environ, **environment}, stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL, timeout=limit_s, check=False).returncode
    except subprocess.TimeoutExpired:
        return None


# For each mutant: its quick tests, and the longer ones, each with its milliseconds.
tests_of = collections.defaultdict(lambda: ([], []))
jobs = os.cpu_count()
with tempfile.TemporaryDirectory() as folder, concurrent.futures.ThreadPoolExecutor(jobs) as pool:
    maps = [pathlib.Path(folder) / str(shard) for shard in range(jobs)]
    ended = pool.map(
        lambda shard: run({'HOIST_MUTANT_MAP': str(maps[shard]), 'GTEST_TOTAL_SHARDS': str(jobs), 'GTEST_SHARD_INDEX': str(shard)}, WHOLE_LIMIT_S),
        range(jobs))
    if any(code != 0 for code in ended):
        sys.exit('the tests fail without a mutant')
    for row in itertools.chain.from_iterable(places.read_text().splitlines() for places in maps):
        test, taken_ms, numbers = row.split('\t')
        if int(taken_ms) <= LONGEST_MS:
            for number in numbers.split():
                tests_of[number][int(taken_ms) > QUICK_MS].append((test, int(taken_ms)))


def noticed(mutant):
    def fails(tests):
        # Twenty times what they take, and more: a mutant that makes a test hang is noticed by this.
        limit_s = 20 + 20 * sum(ms for _, ms in tests) / 1000
        return run({'HOIST_MUTANT': mutant.number}, limit_s, '--gtest_filter=' + ':'.join(test for test, _ in tests)) != 0

    return any(tests and fails(tests) for tests in tests_of[mutant.number])


tried, unseen, failed = collections.Counter(), collections.Counter(), len(gone)
free = 0
with concurrent.futures.ThreadPoolExecutor(jobs) as pool:
    for mutant, seen in zip(mutants, pool.map(noticed, mutants)):
        tried[mutant.file] += 1
        if seen:
            continue
        if key(mutant) in harmless:
            free += 1
            continue
        unseen[mutant.file] += 1
        closed = mutant.file not in floors
        failed += closed
        if closed or wanted.show:
            how = '' if any(tests_of[mutant.number]) else '  (no test comes by)'
            print(f'NOT NOTICED: {mutant.file}:{mutant.line}{how}\n' + '\t'.join(key(mutant)), flush=True)
if len(mutants) == whole:
    for file, count in sorted(tried.items()):
        share = 100 * (count - unseen[file]) // count
        if wanted.show:
            print(f'{file}\t{share}')
        if share < floors.get(file, 0):
            failed += 1
            print(f'{file}: {share} of 100 noticed, {floors[file]} before')
lost = sum(unseen.values())
drawn = f'{len(mutants)} of {whole} mutants (seed {wanted.seed})' if len(mutants) < whole else f'{whole} mutants'
print(f'{drawn}: {len(mutants) - lost - free} noticed, {free} that do no harm, {lost} not noticed')
sys.exit(1 if failed else 0)
