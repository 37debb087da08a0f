"""The Python lines of db/PYTHON.md, run as they stand there, on a recording of make_recording.

    python_page.py FOLDER_OF_PROGRAMS SOURCE_DIR

The server's answer is what `hoist export` writes: the route sends the pieces of the same writer.
"""
import http.server
import os
import re
import subprocess
import sys
import tempfile
import threading
import warnings

import numpy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from harness import check, run_suite

FOLDER, TOP = sys.argv[1:3]
TOKEN = "a-token-of-the-test"
CORE_AGE_TICKS = 123_456_700  # of make_recording


def blocks():
    with open(os.path.join(TOP, "db/PYTHON.md"), encoding="utf-8") as page:
        return re.findall(r"```python\n(.*?)```", page.read(), re.DOTALL)


def recording(folder):
    database = os.path.join(folder, "hoist.db")
    subprocess.run([os.path.join(FOLDER, "make_recording"), database], check=True)
    return database


class Answers(http.server.BaseHTTPRequestHandler):
    csv = b""

    def do_GET(self):
        good = self.path == "/api/v1/sessions/1/export?format=csv" and self.headers["Authorization"] == "Bearer " + TOKEN
        self.send_response(200 if good else 404)
        self.end_headers()
        self.wfile.write(self.csv if good else b"")

    def log_message(self, *_):
        pass


def another_recording(frame):
    """The output as a system of 1 kHz records it, from the ninth second on, by a clock that is 80 ppm fast; and the hoist's time of its samples."""
    truth_s = numpy.arange(8.3, frame.index[-1], 1e-3)
    step = numpy.floor(truth_s * 100).astype(int) + CORE_AGE_TICKS
    place, group = step // 100 % 16, step // 1600
    length = numpy.where(place == 0, 80, numpy.where(group >> numpy.maximum(place - 1, 0) & 1, 50, 20))
    return {"truth_s": truth_s, "their_time_s": 5000 + 1.00008 * truth_s, "their_level": (step % 100 < length).astype(int)}


def the_lines_give_frames_with_the_numbers_of_the_recording():
    with tempfile.TemporaryDirectory() as folder:
        database = recording(folder)
        Answers.csv = subprocess.run([os.path.join(FOLDER, "hoist"), "export", database, "1"], check=True, capture_output=True).stdout
        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Answers)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        os.environ["PATH"] = FOLDER + os.pathsep + os.environ["PATH"]
        names = {"address": f"http://127.0.0.1:{server.server_port}", "token": TOKEN, "database": database}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                for number, block in enumerate(blocks()):
                    check(number == 2 or len(block.strip().splitlines()) == 3, "three lines")
                    if number == 2:
                        names.update(another_recording(names["frame"]))
                    exec(block, names)  # pylint: disable=exec-used
        finally:
            server.shutdown()
        frame, speed = names["frame"], names["speed"]
        check(len(frame) == 2800, f"{len(frame)} samples")
        check(str(frame["utc"].dtype) == "datetime64[ns, UTC]", f"utc is a time: {frame['utc'].dtype}")
        check(list(frame.index[frame["gap_before"] == 1]) == [frame.index[1400]], "the gap")
        check(frame["speed_m_s"].dtype == float and frame["mode"].dtype == int, "numbers are numbers")
        # The other clock is found to a sample of theirs and to a third of a step of ours.
        error_s = names["their_time_on_our_clock_s"] - names["truth_s"]
        check(abs(error_s).max() < 0.004, f"aligned to {abs(error_s).max()} s")
        check((speed["speed_m_s"] == frame["speed_m_s"]).all() and (speed.index == frame.index).all(), "both ways give the same numbers")


if __name__ == "__main__":
    sys.exit(run_suite("PythonPage", [the_lines_give_frames_with_the_numbers_of_the_recording]))
