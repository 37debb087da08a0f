"""The whole system for a long time: soak.py BIN [--minutes N] [--csv FILE]. See deploy/verbs/soak.sh."""
import argparse
import os
import sys
import time

from driver import Driver
from harness import Failed, Hoist, check

EVERY_S = 5.0
SETTLED_S = 240.0
READERS = 4
# What a run may grow by. Memory: 1 MB a day is the aim, but pages come in steps, so a short run is allowed one such step.
MEMORY_KB_PER_H, MEMORY_STEP_KB = 1024 / 24, 768
WAL_LIMIT_KB = 64 * 1024


def of_process(pid):
    with open(f"/proc/{pid}/status") as file:
        fields = dict(line.split(":", 1) for line in file)
    return {"rss_kb": int(fields["VmRSS"].split()[0]), "threads": int(fields["Threads"]), "files": len(os.listdir(f"/proc/{pid}/fd"))}


def line_through(points):
    """Slope per hour of a straight line through (seconds, value), least squares."""
    count = len(points)
    mean_t, mean_v = sum(t for t, _ in points) / count, sum(v for _, v in points) / count
    spread = sum((t - mean_t)**2 for t, _ in points)
    return 3600 * sum((t - mean_t) * (v - mean_v) for t, v in points) / spread if spread else 0.0


class Soak:
    def __init__(self, bin_folder, csv):
        # Sessions of a few minutes: they begin, are recorded, end and are folded, again and again.
        self.hoist = Hoist(bin_folder, None, None, scenario="figure-eight")
        self.hoist.real_time = True  # as on a hoist, where this machine permits it
        self.rows, self.csv = [], csv
        self.walks = self.drives = self.stops = 0

    def note(self, since_s):
        row = {"s": round(since_s, 1)}
        for name, program in (("sim", self.hoist.sim), ("control", self.hoist.core), ("server", self.hoist.server)):
            check(program.process.poll() is None, f"{program.name} has ended by itself ({program.process.returncode})")
            row.update({f"{name}_{key}": value for key, value in of_process(program.process.pid).items()})
        wal = self.hoist.path("hoist.db-wal")
        row["wal_kb"] = os.path.getsize(wal) // 1024 if os.path.exists(wal) else 0
        code, loop = self.hoist.call("GET", "/loop")
        if code == 200:
            row.update({key: loop[key] for key in ("missed", "late", "lateness_p50_s", "lateness_p99_s", "lateness_max_s", "page_faults", "allocations")})
        if self.csv is not None:
            if not self.rows:
                self.csv.write(",".join(row) + "\n")
            self.csv.write(",".join(str(value) for value in row.values()) + "\n")
            self.csv.flush()
        self.rows.append(row)

    def run(self, seconds):
        self.hoist.start()
        readers = [Driver(self.hoist.port, self.hoist.token) for _ in range(READERS)]
        start = time.monotonic()
        try:
            while time.monotonic() - start < seconds:
                self.hoist.recover()
                self.hoist.place_anew()
                if (self.walks + self.drives) % 3 < 2:
                    self.hoist.walk(0.2)
                    self.walks += 1
                    self.wait(start, seconds, lambda: self.hoist.mode() == "user")
                else:
                    readers[0].start()
                    readers[0].hold(0.4, 0.3)
                    self.drives += 1
                    self.wait(start, seconds, lambda: self.hoist.mode() == "remote")
                    readers[0].stick = None
                if self.hoist.mode() == "protective_stop":
                    self.stops += 1
                self.hoist.call("POST", "/stop", {})
                self.hoist.wait_stopped()
        finally:
            for reader in readers:
                reader.close()

    def wait(self, start, seconds, goes_on):
        """A minute and a half of it, with a reading every few seconds."""
        end = time.monotonic() + 90.0
        while time.monotonic() < min(end, start + seconds) and goes_on():
            self.note(time.monotonic() - start)
            time.sleep(EVERY_S)

    def judge(self):
        # Buffers, caches and the first recordings fill in the first minutes; that is no growth.
        half = [row for row in self.rows if row["s"] >= max(SETTLED_S, self.rows[-1]["s"] / 2)]
        check(len(half) >= 6, "too short a run to say anything: five minutes at least")
        hours = (half[-1]["s"] - half[0]["s"]) / 3600
        bad = []
        print(f"{'':24} {'at the end':>12} {'per hour':>12}")
        for name in ("sim", "control", "server"):
            for key, unit in (("rss_kb", "kB"), ("files", ""), ("threads", "")):
                points = [(row["s"], row[f"{name}_{key}"]) for row in half]
                slope = line_through(points)
                print(f"{name + ' ' + key:24} {points[-1][1]:12} {slope:12.1f} {unit}")
                allowed = MEMORY_KB_PER_H * hours + MEMORY_STEP_KB if key == "rss_kb" else 0.99
                if slope * hours > allowed:
                    bad.append(f"{name} {key} grew by {slope * hours:.0f} in {hours:.2f} h")
        most = max(row["wal_kb"] for row in self.rows)
        print(f"{'database log, most':24} {most:12} {'':12} kB")
        if most > WAL_LIMIT_KB:
            bad.append(f"the database's log reached {most} kB")
        last = self.rows[-1]
        for key in ("late", "missed", "page_faults", "allocations"):
            print(f"{'loop ' + key:24} {last[key]:12}")
        for key in ("lateness_p50_s", "lateness_p99_s", "lateness_max_s"):
            print(f"{'loop ' + key:24} {max(row[key] for row in self.rows) * 1e3:12.3f} {'':12} ms, the worst ten seconds")
        if last["allocations"] != 0:
            bad.append(f"{last['allocations']} requests for memory in the control thread")
        print(f"{self.walks} walks, {self.drives} drives, {self.stops} stops by themselves, {last['s'] / 3600:.2f} h")
        check(not bad, "; ".join(bad))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("bin")
    parser.add_argument("--minutes", type=float, default=10.0)
    parser.add_argument("--csv")
    options = parser.parse_args()
    with open(options.csv or os.devnull, "w") as csv:
        soak = Soak(options.bin, csv if options.csv else None)
        try:
            soak.run(60 * options.minutes)
            soak.judge()
        except Failed as error:
            print(f"soak: {error}\n{soak.hoist.logs()}")
            return 1
        finally:
            soak.hoist.stop()
        soak.hoist.forget()
    return 0


if __name__ == "__main__":
    sys.exit(main())
