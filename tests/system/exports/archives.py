"""Our archives read by Python's zipfile, csv, json and sqlite3, and a BIDS data set by the names and columns that its specification asks for.

    archives.py FOLDER_OF_PROGRAMS
"""
import csv
import io
import json
import os
import re
import shutil
import sqlite3
import subprocess
import sys
import tempfile
import unittest
import zipfile

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), ".."))
from harness import run_suite

FOLDER = sys.argv[1]
MAKE, HOIST = os.path.join(FOLDER, "make_recording"), os.path.join(FOLDER, "hoist")


def hoist(*arguments):
    return subprocess.run([HOIST, *arguments], check=True, capture_output=True).stdout


class Archives(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.database = os.path.join(cls.folder.name, "hoist.db")
        subprocess.run([MAKE, cls.database], check=True)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def archive(self, *arguments):
        data = hoist("export", self.database, *arguments)
        archive = zipfile.ZipFile(io.BytesIO(data))
        self.assertIsNone(archive.testzip())
        return archive

    def csv_of(self, session):
        text = hoist("export", self.database, str(session), "--no-comments").decode()
        return list(csv.DictReader(io.StringIO(text)))

    def exported(self, session):
        return json.loads(hoist("export", self.database, str(session), "--format", "json"))

    def a_session_as_an_archive_holds_the_same_files_as_the_single_exports(self):
        archive = self.archive("1", "--format", "zip")
        head = "session_1/"
        self.assertEqual(
            sorted(archive.namelist()),
            sorted(head + name for name in ("session.csv", "session_events.csv", "session_can.log", "session.mcap", "manifest.json", "figures.json")),
        )
        self.assertEqual(archive.read(head + "session.csv"), hoist("export", self.database, "1", "--no-comments"))
        self.assertEqual(archive.read(head + "session.mcap"), hoist("export", self.database, "1", "--format", "mcap"))
        self.assertEqual(json.loads(archive.read(head + "manifest.json"))["session"]["subject"], "P-017")
        self.assertEqual(archive.getinfo(head + "session.csv").date_time[:3], (2026, 9, 21))
        self.assertEqual(archive.getinfo(head + "session.csv").external_attr >> 16, 0o100644)

    def reports_are_the_pages_that_the_tool_writes_into_a_folder(self):
        folder = os.path.join(self.folder.name, "pages")
        hoist("report", self.database, "--session", "1", "--session", "2", "--session", "3", "--out", folder)
        archive = self.archive("--bundle", "reports")
        self.assertEqual(archive.namelist(), ["session-1.html", "session-2.html", "session-3.html", "group.html"])
        for name in archive.namelist():
            with open(os.path.join(folder, name), "rb") as page:
                self.assertEqual(archive.read(name), page.read(), name)
        self.assertEqual(self.archive("3", "--bundle", "reports").namelist(), ["session-3.html"])

    def filters_choose_the_sessions(self):
        def sessions(*filters):
            return sorted({name.split("/")[0] for name in self.archive("--bundle", "files", *filters).namelist()})

        self.assertEqual(sessions(), ["session_1", "session_2", "session_3"])
        self.assertEqual(sessions("--subject", "P-017"), ["session_1", "session_2"])
        self.assertEqual(sessions("--exercise", "square"), ["session_2", "session_3"])
        self.assertEqual(sessions("--from", "2026-09-22", "--subject", "P-017"), ["session_2"])
        self.assertEqual(sessions("--to", "2026-09-21"), ["session_1"])
        for tag in ("baseline", "tired2", "1"):
            self.assertEqual(sessions("--tag", tag), ["session_3"])
        for tag in ("tired", "base", "Walked", "baseline)", "#baseline"):
            with self.assertRaises(subprocess.CalledProcessError, msg=tag):
                hoist("export", self.database, "--bundle", "files", "--tag", tag)
        with self.assertRaises(subprocess.CalledProcessError) as refused:
            hoist("export", self.database, "--bundle", "files", "--no-simulated")
        self.assertIn(b"no session fits", refused.exception.stderr)
        with self.assertRaises(subprocess.CalledProcessError) as refused:
            hoist("export", self.database, "--bundle", "files", "--from", "21.9.2026")
        self.assertIn(b"YYYY-MM-DD", refused.exception.stderr)

    def sql(self, *statements, given=None):
        done = subprocess.run([HOIST, "sql", self.database, *statements], input=given, capture_output=True, text=True)
        return done.returncode, list(csv.reader(io.StringIO(done.stdout))), done.stderr

    def samples_are_rows_of_a_table_with_the_numbers_of_the_csv(self):
        names = ["time_s", "gap_before", "tick", "x_m", "mode", "left_counts", "utc"]
        code, rows, _ = self.sql(f"SELECT {', '.join(names)} FROM samples WHERE session_id = 2")
        self.assertEqual((code, rows[0]), (0, names))
        expected = self.csv_of(2)
        self.assertEqual(len(rows) - 1, len(expected))
        for row, sample in zip(rows[1:], expected):
            for name, value in zip(names, row):
                same = value == sample[name] if name == "utc" else float(value) == float(sample[name])
                self.assertTrue(same, f"{name}: {value}, expected {sample[name]}")
        # A range gives what the same condition gives on all rows.
        _, some, _ = self.sql("SELECT tick FROM samples WHERE session_id = 2 AND time_s >= 13.5 AND time_s < 15.5")
        self.assertEqual([r[0] for r in some[1:]], [s["tick"] for s in expected if 13.5 <= float(s["time_s"]) < 15.5])
        self.assertEqual(self.sql("SELECT count(*), sum(gap_before) FROM samples")[1][1], [str(3 * len(expected)), "3"])
        self.assertEqual(self.sql("SELECT count(*) FROM samples WHERE session_id = 99")[1][1], ["0"])

    def plain_tables_of_several_sessions_hold_the_numbers_of_the_csv(self):
        path = os.path.join(self.folder.name, "plain.sqlite")
        hoist("export", self.database, "--bundle", "sqlite", "--subject", "P-017", "--out", path)
        file = sqlite3.connect(f"file:{path}?mode=ro", uri=True)
        file.row_factory = sqlite3.Row
        self.assertEqual(file.execute("PRAGMA integrity_check").fetchone()[0], "ok")
        self.assertEqual(file.execute("PRAGMA application_id").fetchone()[0], 0, "no file of recordings")
        for session in (1, 2):
            rows = file.execute("SELECT * FROM samples WHERE session_id = ? ORDER BY rowid", (session,)).fetchall()
            expected = self.csv_of(session)
            self.assertEqual(len(rows), len(expected))
            self.assertEqual(set(rows[0].keys()), {"session_id"} | expected[0].keys())
            for row, sample in zip(rows, expected):
                for name, value in sample.items():
                    self.assertEqual(str(row[name]) if name == "utc" else float(row[name]), value if name == "utc" else float(value), name)
        words = {row["name"]: row["unit"] for row in file.execute("SELECT * FROM columns WHERE session_id = 1")}
        self.assertEqual((words["x_m"], words["left_alpha_rad"], words["time_s"], words["mode"]), ("m", "rad", "s", ""))
        told = dict(file.execute("SELECT * FROM sessions WHERE session_id = 2").fetchone())
        manifest, figures = json.loads(told.pop("manifest")), json.loads(told.pop("figures"))
        self.assertEqual(told, {"session_id": 2, "subject": "P-017", "started_utc": "2026-09-22T14:13:20.123456Z", "simulated": 1,
                                "exercise": told["exercise"], "note": "", "samples": 2800})
        self.assertEqual(json.loads(told["exercise"])["shape"], "square")
        self.assertEqual(manifest["session"]["id"], 2)
        self.assertEqual(figures["session"], 2)
        one = lambda table: [dict(row) for row in file.execute(f"SELECT * FROM {table} WHERE session_id = 1")]
        self.assertEqual([(e["kind"], e["name"], e["time_s"], e["value"]) for e in one("events")][0], ("parameter_changed", "lean_range_rad", 0.5, 0.125))
        self.assertEqual([(m["tick"], round(m["time_s"], 3), m["kind"], m["text"]) for m in one("markers")],
                         [(1420, 14.2, "note", "in the gap"), (60, 0.6, "note", 'turned; "left", by the ramp')])
        self.assertEqual({(g["stream"], g["from_tick"], g["to_tick"], g["reason"]) for g in one("gaps")}, {("ticks", 1400, 1499, "not_received")})
        self.assertEqual([(c["name"], c["value"], c["before"], c["unit"]) for c in one("parameter_changes")], [("lean_range_rad", 0.125, 0.25, "rad")])
        self.assertEqual({p["name"]: (p["value"], p["unit"]) for p in one("parameters")}["lean_range_rad"][1], "rad")
        tables = {row[0] for row in file.execute("SELECT name FROM sqlite_schema WHERE type = 'table'")}
        self.assertEqual(tables, {"sessions", "columns", "samples", "events", "markers", "parameters", "parameter_changes", "gaps"})
        if shutil.which("sqlite3"):
            done = subprocess.run(["sqlite3", "-csv", path, "SELECT session_id, count(*), max(distance_m) > 0 FROM samples GROUP BY 1"], check=True, capture_output=True, text=True)
            self.assertEqual(done.stdout, "1,2800,1\n2,2800,1\n")
        self.assertEqual([name for name in os.listdir(self.folder.name) if name.startswith(".export")], [], "nothing stays behind")

    def plain_tables_of_one_session_have_the_chosen_columns(self):
        path = os.path.join(self.folder.name, "one.sqlite")
        hoist("export", self.database, "3", "--format", "sqlite", "--columns", "psi_rad,bus_up", "--no-constant", "--out", path)
        file = sqlite3.connect(path)
        self.assertEqual([row[1] for row in file.execute("PRAGMA table_info(samples)")], ["session_id", "time_s", "utc", "gap_before", "psi_rad"])
        self.assertEqual(file.execute("SELECT count(*), sum(gap_before) FROM samples").fetchone(), (2800, 1))

    def sql_only_reads_and_says_what_is_wrong(self):
        for statement in ("DELETE FROM sessions", "ATTACH 'x.db' AS x", "PRAGMA query_only = 0", "CREATE TABLE x (y)", "VACUUM INTO 'x.db'"):
            code, rows, words = self.sql(statement)
            self.assertEqual((code, rows), (1, []), statement)
            self.assertRegex(words, "only read", statement)
        code, _, words = self.sql("SELECT nonsense FROM samples")
        self.assertEqual((code, words), (1, "hoist sql: no such column: nonsense\n"))
        code, rows, _ = self.sql(given="SELECT 1 AS a\n;\nSELECT 2 AS b")
        self.assertEqual((code, rows), (0, [["a"], ["1"], ["b"], ["2"]]))

    # Names and columns by BIDS 1.10: schema/rules/files/raw/{motion,channels,events}.yaml, rules/tabular_data/motion.yaml, rules/sidecars/motion.yaml.
    def a_data_set_is_laid_out_as_motion_bids(self):
        archive = self.archive("--bundle", "bids")
        names = archive.namelist()
        top = {"dataset_description.json", "participants.tsv", "participants.json", "README", ".bidsignore"}
        entity = r"(sub-[0-9a-zA-Z]+)/(ses-[0-9a-zA-Z]+)/"
        motion = entity + r"motion/\1_\2_task-[0-9a-zA-Z]+_tracksys-[0-9a-zA-Z]+_run-[0-9]+_"
        kinds = (r"(motion\.(tsv|json)|channels\.tsv|events\.tsv|manifest\.json)$", r"\1_\2_scans\.tsv$")
        for name in names:
            fits = name in top or re.match(motion + kinds[0], name) or re.match(entity + kinds[1], name)
            self.assertTrue(fits, name)
        self.assertEqual(len(names), len(set(names)))
        self.assertLessEqual(top, set(names))
        description = json.loads(archive.read("dataset_description.json"))
        self.assertTrue({"Name", "BIDSVersion"} <= description.keys())
        participants = list(csv.DictReader(io.StringIO(archive.read("participants.tsv").decode()), delimiter="\t"))
        self.assertEqual([(p["participant_id"], p["code"]) for p in participants], [("sub-P017", "P-017"), ("sub-P018", "P-018")])
        self.assertEqual(set(json.loads(archive.read("participants.json"))), {"code"})
        self.assertEqual([n for n in names if n.endswith("_motion.tsv")], [
            "sub-P017/ses-20260921/motion/sub-P017_ses-20260921_task-straight_tracksys-hoist_run-1_motion.tsv",
            "sub-P017/ses-20260922/motion/sub-P017_ses-20260922_task-square_tracksys-hoist_run-1_motion.tsv",
            "sub-P018/ses-20260922/motion/sub-P018_ses-20260922_task-square_tracksys-hoist_run-1_motion.tsv",
        ])
        for session, name in enumerate((n for n in names if n.endswith("_motion.tsv")), 1):
            self.check_recording(archive, session, name.removesuffix("_motion.tsv"))
        scans = {}
        for name in (n for n in names if n.endswith("_scans.tsv")):
            for scan in csv.DictReader(io.StringIO(archive.read(name).decode()), delimiter="\t"):
                scans[os.path.dirname(name) + "/" + scan["filename"]] = scan["acq_time"]
        begun = {n: self.exported(session)["session"]["started_utc"] for session, n in enumerate((n for n in names if n.endswith("_motion.tsv")), 1)}
        self.assertEqual(scans, begun)
        everything = b"".join(archive.read(name) for name in names)
        for text in (b"by the ramp", b"Walked well"):
            self.assertNotIn(text, everything, "free text stays at home")

    def check_recording(self, archive, session, stem):
        def table(kind):
            return list(csv.DictReader(io.StringIO(archive.read(f"{stem}_{kind}.tsv").decode()), delimiter="\t", quoting=csv.QUOTE_NONE))

        channels = table("channels")
        self.assertEqual(list(channels[0])[:5], ["name", "component", "type", "tracked_point", "units"])
        types = {"ACCEL", "ANGACC", "GYRO", "JNTANG", "LATENCY", "MAGN", "MISC", "ORNT", "POS", "VEL"}
        for channel in channels:
            self.assertIn(channel["type"], types)
            self.assertIn(channel["component"], {"x", "y", "z", "n/a"})
            self.assertTrue(all(channel.values()), channel)
        exported = self.exported(session)
        # The latency, then every live value of the recording with its unit.
        self.assertEqual([(c["name"], c["units"]) for c in channels],
                         [("latency_s", "s")] + [(c["name"], c["unit"] or "n/a") for c in exported["columns"][2:]])
        self.assertEqual([c["type"] for c in channels if c["type"] == "LATENCY"], ["LATENCY"])
        units = {"LATENCY": {"s"}, "POS": {"m"}, "VEL": {"m/s"}, "ORNT": {"rad"}, "GYRO": {"rad/s"}}
        for channel in channels:
            self.assertIn(channel["units"], units.get(channel["type"], {channel["units"]}), channel)
        kinds = {c["name"]: (c["component"], c["type"], c["tracked_point"]) for c in channels}
        for name, kind in {"x_m": ("x", "POS", "hoist"), "y_m": ("y", "POS", "hoist"), "psi_rad": ("z", "ORNT", "hoist"),
                           "left_alpha_rad": ("y", "ORNT", "strut_left"), "right_beta_rad": ("x", "ORNT", "strut_right"),
                           "base_yaw_rate_rad_s": ("z", "GYRO", "chassis"), "wheel_left_m_s": ("x", "VEL", "wheel_left"),
                           "mode": ("n/a", "MISC", "n/a")}.items():
            self.assertEqual(kinds[name], kind, name)
        sidecar = json.loads(archive.read(stem + "_motion.json"))
        self.assertTrue({"TaskName", "TrackingSystemName"} <= sidecar.keys())
        self.assertIn(f"_task-{sidecar['TaskName']}_tracksys-{sidecar['TrackingSystemName']}_", stem)
        self.assertEqual(sidecar["SamplingFrequency"], 100)
        times = exported["data"]["time_s"]
        self.assertAlmostEqual(sidecar["SamplingFrequencyEffective"], (len(times) - 1) / (times[-1] - times[0]), places=2)
        self.assertEqual(sidecar["TrackedPointsCount"], len({c["tracked_point"] for c in channels} - {"n/a"}))
        self.assertEqual(sidecar["MotionChannelCount"], len(channels))
        for kind in types:
            self.assertEqual(sidecar.get(kind + "ChannelCount", 0), sum(c["type"] == kind for c in channels), kind)
        # Hashes of programs, layout and calibration, and everything else: the manifest of the other exports, without the note.
        del exported["manifest"]["session"]["note"]
        self.assertEqual(json.loads(archive.read(stem + "_manifest.json")), exported["manifest"])
        rows = [line.split("\t") for line in archive.read(stem + "_motion.tsv").decode().splitlines()]
        expected = self.csv_of(session)
        self.assertEqual(len(rows), len(expected))
        first = float(expected[0]["time_s"])
        for row, sample in zip(rows, expected):
            self.assertEqual(len(row), len(channels))
            self.assertAlmostEqual(float(row[0]), float(sample["time_s"]) - first, places=5)
            for value, channel in zip(row[1:], channels[1:]):
                self.assertEqual(value, sample[channel["name"]], channel["name"])
        # At the times of the CSV of events, from the first sample on.
        told = csv.DictReader(io.StringIO(hoist("export", self.database, str(session), "--format", "events", "--no-comments").decode()))
        told = list(told)
        self.assertEqual([e["trial_type"] for e in table("events")], [e["kind"] for e in told])
        for event, row in zip(table("events"), told):
            self.assertAlmostEqual(float(event["onset"]) + first, float(row["time_s"]), delta=0.001)
        self.assertEqual({e["duration"] for e in table("events")}, {"0"})
        self.assertEqual({e["trial_type"] for e in table("events")}, {"parameter_changed", "marker"})


if __name__ == "__main__":
    Archives.setUpClass()
    suite = Archives()
    code = run_suite("ExportArchives", [
        suite.a_session_as_an_archive_holds_the_same_files_as_the_single_exports,
        suite.reports_are_the_pages_that_the_tool_writes_into_a_folder,
        suite.filters_choose_the_sessions,
        suite.samples_are_rows_of_a_table_with_the_numbers_of_the_csv,
        suite.plain_tables_of_several_sessions_hold_the_numbers_of_the_csv,
        suite.plain_tables_of_one_session_have_the_chosen_columns,
        suite.sql_only_reads_and_says_what_is_wrong,
        suite.a_data_set_is_laid_out_as_motion_bids,
    ])
    Archives.tearDownClass()
    sys.exit(code)
