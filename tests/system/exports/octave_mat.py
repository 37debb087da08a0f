"""Our MAT-files read by Octave, every number compared with the CSV.

    octave_mat.py FOLDER_OF_PROGRAMS
"""
import csv
import io
import os
import subprocess
import sys
import tempfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from harness import check, run_suite

FOLDER = sys.argv[1]
HOIST = os.path.join(FOLDER, "hoist")
# A line per variable: its name, its class, its numbers. Integers of 64 bits as such, for a double could not hold them.
SCRIPT = """
file = load(argv(){1});
told = jsondecode(file.manifest);
events = jsondecode(file.events);
printf('%s %s %d\\n', told.session.subject, told.parameters.lean_range_rad.unit, numel(events));
for name = fieldnames(file)'
  value = file.(name{1});
  if ischar(value) continue; end
  if isinteger(value) form = ' %d'; else form = ' %.17g'; end
  printf('%s %s', name{1}, class(value));
  printf(form, value);
  printf('\\n');
end
"""


def octave_reads_the_numbers_of_the_csv():
    with tempfile.TemporaryDirectory() as folder:
        database, file, script = (os.path.join(folder, name) for name in ("hoist.db", "walk.mat", "read.m"))
        subprocess.run([os.path.join(FOLDER, "make_recording"), database], check=True)
        subprocess.run([HOIST, "export", database, "1", "--format", "mat", "--out", file], check=True)
        text = subprocess.run([HOIST, "export", database, "1", "--no-comments"], check=True, capture_output=True, text=True).stdout
        samples = list(csv.DictReader(io.StringIO(text)))
        with open(script, "w", encoding="utf-8") as out:
            out.write(SCRIPT)
        done = subprocess.run(["octave-cli", "--norc", "--quiet", script, file], capture_output=True, text=True, timeout=120)
        check(done.returncode == 0, done.stderr)
        head, *lines = done.stdout.splitlines()
        check(head == "P-017 rad 3", f"manifest and events: {head}")
        names = set(samples[0]) - {"utc"}
        check({line.split(" ", 1)[0] for line in lines} == names, "one variable per live value")
        for line in lines:
            name, kind, *values = line.split(" ")
            whole = kind.startswith(("int", "uint"))
            check(len(values) == len(samples), f"{name}: {len(values)} samples")
            for value, sample in zip(values, samples):
                same = int(value) == int(sample[name]) if whole else float(value) == float(sample[name])
                check(same, f"{name}: {value}, expected {sample[name]}")


if __name__ == "__main__":
    sys.exit(run_suite("OctaveMat", [octave_reads_the_numbers_of_the_csv]))
