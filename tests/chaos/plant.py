#!/usr/bin/python3
"""plant.py PLANTED TOP OUT LIST FOLDER...: copies the C++ files of the folders (relative to TOP) to OUT, with the errors of PLANTED (planted.tsv) in
them. A program built of the copies runs as before, until it chooses one error (tests/mutants/mutant_switch.hpp). LIST gets one line for each: number,
file, line, hazard and what is wrong, the source line.

A row of PLANTED: file, source line without its indentation, what is replaced in it, by what, hazard, what the programmer got wrong; separated by
tabs. What ends with a semicolon is a statement, anything else an expression; a statement replaced by nothing is left out. The line must stand in its
file exactly once, and what is replaced exactly once in the line, or this fails: a row never tests something else unnoticed."""
import pathlib
import sys

planted, top, out, listing, *folders = sys.argv[1:]
top, out = pathlib.Path(top), pathlib.Path(out)
names = sorted(str(path.relative_to(top)) for folder in folders for path in (top / folder).glob('*.?pp'))
files = {name: (top / name).read_text().split('\n') for name in names}
sources = {name: [line.strip() for line in lines] for name, lines in files.items()}
wrong, listed, taken = [], [], set()

for number, row in enumerate(row for row in pathlib.Path(planted).read_text().splitlines() if not row.startswith('#')):
    place = f'{planted}, error {number}: '
    if row.count('\t') != 5:
        wrong.append(place + 'a row has six columns')
        continue
    name, source, old, new, hazard, words = row.split('\t')
    times = sources.get(name, []).count(source)
    if times != 1 or source.count(old) != 1 or (name, source) in taken:
        wrong.append(place + (f'{name} has this line {times} times: {source}' if times != 1 else
                              f'the line has this {source.count(old)} times: {old}' if source.count(old) != 1 else 'a second error in one line'))
        continue
    taken.add((name, source))
    line = sources[name].index(source)
    switch = f'hoist_mutants::on({number})'
    if not old.endswith(';'):
        changed = f'({switch} ? ({new}) : ({old}))'
    elif new:
        changed = f'{{ if ({switch}) {{ {new} }} else {{ {old} }} }}'
    else:
        changed = f'{{ if (!{switch}) {{ {old} }} }}'
    files[name][line] = files[name][line].replace(old, changed)
    listed.append(f'{number}\t{name}\t{line + 1}\t{hazard}: {words}\t{source}')

if wrong:
    sys.exit('\n'.join(wrong))
for name, lines in files.items():
    (out / name).parent.mkdir(parents=True, exist_ok=True)
    (out / name).write_text('#include "tests/mutants/mutant_switch.hpp"\n#line 1\n' + '\n'.join(lines))
pathlib.Path(listing).write_text('\n'.join(listed) + '\n')
