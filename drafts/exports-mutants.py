import subprocess, sys, os
T="/tmp/w/exports"; F=T+"/db/export/bids.cpp"
src=open(F).read()
M=[
("wrong unit of a channel",'std::string_view(column.unit)})','std::string_view(column.unit == "rad" ? "deg" : column.unit.c_str())})'),
("alpha and beta exchanged",'meaning == axis::x_start || meaning == axis::beta ','meaning == axis::x_start || meaning == axis::alpha '),
("no participants.json",'text("participants.json", pretty(words)), ',''),
("no scans",'for (const auto& [name, rows] : scans_) files','for (const auto& [name, rows] : scans_) if (name.empty()) files'),
("no manifest",'files.push_back(with_source(stem + "_manifest.json"','if (stem.empty()) files.push_back(with_source(stem + "_manifest.json"'),
("no events",'files.push_back(with_source(stem + "_events.tsv"','if (stem.empty()) files.push_back(with_source(stem + "_events.tsv"'),
("another layout hash",'manifest["session"].erase("note");','manifest["session"].erase("note"); manifest["layout_hash"] = "0000000000000000";'),
("wrong rate",'kNominal_hz = 100;','kNominal_hz = 1000;'),
("effective rate counts one sample more",'static_cast<double>(source.sample_count - 1) / source.info','static_cast<double>(source.sample_count + 9) / source.info'),
("onset from the session's start twice",'microseconds_since(begin_ns, time_ns)','microseconds_since(begin_ns + 10000000, time_ns)'),
("scan time of the first session",'utc_text(info.started_utc_ns) + "\\n"','utc_text(first_utc_ns_) + "\\n"'),
("one row left out",'if (!source_.wanted(tick)) continue;\n      if (!source_.written_tick)','if (!source_.wanted(tick) || tick == 77) continue;\n      if (!source_.written_tick)'),
("notes in the manifest",'manifest["session"].erase("note");',''),
("points counted with n/a",'if (channel.point != "n/a") points','if (!channel.point.empty()) points'),
]
try:
  for name,a,b in M:
    assert a in src,(name,a)
    open(F,"w").write(src.replace(a,b,1))
    r=subprocess.run(["ninja","-C",T+"/build","-j2","hoist"],capture_output=True,text=True)
    if r.returncode: print(name,": DOES NOT BUILD",r.stdout[-300:],flush=True); continue
    r=subprocess.run(["/usr/bin/python3",T+"/tests/system/exports/archives.py",T+"/build/bin"],capture_output=True,text=True,env=dict(os.environ,HOIST_CASES="a_data_set_is_laid_out_as_motion_bids"))
    print(name,":","noticed" if r.returncode else "SURVIVED",r.stdout[-200:].replace("\n"," | "),flush=True)
finally:
  open(F,"w").write(src)
