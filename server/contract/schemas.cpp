// The JSON schemas of requests and answers (JSON Schema 2020-12, as OpenAPI 3.1 uses it).
#include "server/contract/schemas.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <string_view>

#include "control/contract/calibration.hpp"
#include "control/contract/exercises.hpp"
#include "control/contract/guided_path.hpp"
#include "control/contract/params.hpp"
#include "db/metrics/metric_list.hpp"
#include "db/store/change_reasons.hpp"
#include "db/store/patient_code.hpp"
#include "db/store/session_types.hpp"
#include "server/contract/audit.hpp"
#include "server/contract/jobs.hpp"
#include "server/contract/reasons.hpp"
#include "server/contract/rehearsals.hpp"
#include "server/contract/topics.hpp"

namespace hoist::server {

using nlohmann::json;

namespace {
constexpr std::string_view kSchemas = R"json({
"OpenApi": {"type": "object", "required": ["openapi", "info", "paths", "components"], "properties": {"openapi": {"const": "3.1.0"}}},
"Empty": {"type": "object", "additionalProperties": false, "description": "No fields; the body may be left out."},
"Echo": {"type": "number", "minimum": 0, "description": "time_ns of the newest record that the sender had seen. When it is older than 1 s, or not from this run of the core, motion does not begin and no stop is left (stale_command). Left out: over REST the first byte of the request counts"},
"AcknowledgeRequest": {"type": "object", "properties": {"echo": {"$ref": "#/components/schemas/Echo"}, "seen": {"type": "array", "minItems": 1, "maxItems": 53, "items": {"type": "string", "maxLength": 32},
  "description": "Names of the faults that were shown when the hand went down, see /api/v1/faults; refused when another has come since"}},
  "additionalProperties": false, "description": "The body may be left out."},
"AlarmPauseRequest": {"type": "object", "required": ["paused"], "properties": {"paused": {"type": "boolean",
  "description": "true: the alarms in force stop sounding for two minutes; false: they sound again"}}, "additionalProperties": false},
"LookedAt": {"type": "integer", "minimum": 1, "maximum": 4294967295,
  "description": "Version of the parameters that were looked at; refused when others have changed them meanwhile, or the core was restarted"},
"TrialTime": {"type": "number", "minimum": 1, "maximum": 120, "description": "Only on trial: the values before come back after so many seconds unless confirmed"},
"ParameterNumbers": {"type": "object", "minProperties": 1, "additionalProperties": {"type": "number"}, "description": "Names and new values"},
"KeepRequest": {"type": "object", "properties": {"version": {"$ref": "#/components/schemas/LookedAt"}}, "additionalProperties": false,
  "description": "The body may be left out."},
"UserName": {"type": "string", "minLength": 2, "maxLength": 32, "description": "For signing in: a-z 0-9 . _ -"},
"DisplayName": {"type": "string", "minLength": 1, "maxLength": 64, "description": "One line, as screens show it"},
"RoleName": {"type": "string", "enum": ["viewer", "therapist", "engineer"]},
"Password": {"type": "string", "minLength": 12, "maxLength": 128},
"WhoAmI": {"type": "object", "required": ["signed_in", "user", "display_name", "role", "has_pin", "seconds_left", "here", "set_up", "device", "problem"], "properties": {"signed_in": {"type": "boolean"},
  "user": {"type": ["string", "null"], "description": "local: whoever uses this computer itself"}, "display_name": {"type": ["string", "null"]},
  "role": {"anyOf": [{"$ref": "#/components/schemas/RoleName"}, {"type": "null"}]}, "has_pin": {"type": ["boolean", "null"], "description": "null: no account"},
  "seconds_left": {"type": ["integer", "null"], "description": "Until this sign-in ends at the latest; null: it does not end by itself"},
  "here": {"type": "array", "description": "Who has signed in on this device and may use a PIN, latest first", "items": {"type": "object", "required": ["user", "display_name"],
    "properties": {"user": {"type": "string"}, "display_name": {"type": "string"}}, "additionalProperties": false}},
  "set_up": {"type": "object", "required": ["needed", "switch_on", "seconds_left"], "properties": {"needed": {"type": "boolean", "description": "The accounts were read, and there is no engineer yet"},
    "switch_on": {"type": "boolean"}, "seconds_left": {"type": "integer", "description": "How long the code is still valid; 0 = none is"}}, "additionalProperties": false},
  "device": {"type": "object", "required": ["name", "language"], "properties": {"name": {"type": "string", "description": "Of this hoist"},
    "language": {"$ref": "#/components/schemas/LanguageOrNull"}}, "additionalProperties": false},
  "problem": {"type": ["string", "null"], "description": "Why the accounts cannot be used; for the engineer"}}, "additionalProperties": false},
"LanguageOrNull": {"anyOf": [{"type": "string", "enum": ["en", "de"]}, {"type": "null"}], "description": "null: as each browser asks"},
"SignInRequest": {"type": "object", "required": ["user"], "properties": {"user": {"type": "string", "maxLength": 64}, "password": {"type": "string", "maxLength": 128},
  "pin": {"type": "string", "maxLength": 8, "description": "Instead of the password"}}, "additionalProperties": false},
"PasswordChange": {"type": "object", "required": ["password", "new_password"], "properties": {"password": {"type": "string", "maxLength": 128, "description": "The present one"},
  "new_password": {"$ref": "#/components/schemas/Password"}}, "additionalProperties": false},
"PinChange": {"type": "object", "required": ["password", "pin"], "properties": {"password": {"type": "string", "maxLength": 128},
  "pin": {"anyOf": [{"type": "string", "minLength": 4, "maxLength": 8, "description": "Digits"}, {"type": "null"}], "description": "null removes it"}}, "additionalProperties": false},
"Ticket": {"type": "object", "required": ["ticket"], "properties": {"ticket": {"type": "string"}}, "additionalProperties": false},
"SetUpRequest": {"type": "object", "required": ["code", "user", "display_name", "password"], "properties": {"code": {"type": "string", "maxLength": 16},
  "user": {"$ref": "#/components/schemas/UserName"}, "display_name": {"$ref": "#/components/schemas/DisplayName"}, "password": {"$ref": "#/components/schemas/Password"}}, "additionalProperties": false},
"User": {"type": "object", "required": ["user", "display_name", "role", "enabled", "has_pin", "etag"], "properties": {"user": {"type": "string"}, "display_name": {"type": "string"},
  "role": {"$ref": "#/components/schemas/RoleName"}, "enabled": {"type": "boolean"}, "has_pin": {"type": "boolean"},
  "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"UserList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/User"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"NewUser": {"type": "object", "required": ["user", "display_name", "role", "password"], "properties": {"user": {"$ref": "#/components/schemas/UserName"},
  "display_name": {"$ref": "#/components/schemas/DisplayName"}, "role": {"$ref": "#/components/schemas/RoleName"}, "password": {"$ref": "#/components/schemas/Password"}}, "additionalProperties": false},
"UserPatch": {"type": "object", "minProperties": 1, "properties": {"display_name": {"$ref": "#/components/schemas/DisplayName"}, "role": {"$ref": "#/components/schemas/RoleName"},
  "enabled": {"type": "boolean"}, "password": {"$ref": "#/components/schemas/Password"}}, "additionalProperties": false},
"Token": {"type": "object", "required": ["id", "user", "name", "scope", "created_utc_s", "expires_utc_s", "etag"], "properties": {"id": {"type": "integer"}, "user": {"type": "string"}, "name": {"type": "string"},
  "scope": {"$ref": "#/components/schemas/RoleName"}, "created_utc_s": {"type": "integer"}, "expires_utc_s": {"type": "integer"},
  "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"TokenList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Token"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"NewToken": {"type": "object", "required": ["name", "scope", "days"], "properties": {"name": {"type": "string", "minLength": 1, "maxLength": 64, "description": "What it is for"},
  "scope": {"$ref": "#/components/schemas/RoleName", "description": "The most it may do; never more than its owner"}, "days": {"type": "integer", "minimum": 1, "maximum": 366}}, "additionalProperties": false},
"TokenMade": {"type": "object", "required": ["id", "token"], "properties": {"id": {"type": "integer"}, "token": {"type": "string", "description": "Shown this once: Authorization: Bearer ..."}}, "additionalProperties": false},
"AuditList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"type": "object", "required": ["id", "utc_ms", "steady_ns", "user", "role", "address",
  "action", "target", "before", "after", "result", "digest"], "properties": {"id": {"type": "integer"}, "utc_ms": {"type": "integer"}, "steady_ns": {"type": "integer"}, "user": {"type": "string"},
  "role": {"type": "string"}, "address": {"type": "string"}, "action": {"$ref": "#/components/schemas/AuditAction"},
  "target": {"type": "string", "description": "Of an action: the protocol and what it was about; else the path"}, "before": {"type": ["string", "null"]}, "after": {"type": ["string", "null"]},
  "result": {"type": "string", "description": "HTTP status, or done, or the reason of a refusal"}, "digest": {"type": "string"}}, "additionalProperties": false}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"AuditCheck": {"type": "object", "required": ["rows", "first_wrong", "head"], "properties": {"rows": {"type": "integer"}, "first_wrong": {"type": ["integer", "null"]},
  "head": {"type": "string", "description": "Digest of the newest row: note it elsewhere to prove later that no row was cut off"}}, "additionalProperties": false},
"Words": {"type": "object", "required": ["en", "de"], "properties": {"en": {"type": "string"}, "de": {"type": "string"}}, "additionalProperties": false},
"FieldError": {"type": "object", "required": ["field", "message"], "properties": {"field": {"type": "string"}, "message": {"type": "string"}, "value": {"type": "number"},
  "min": {"type": "number"}, "max": {"type": "number"}}, "additionalProperties": false},
"Problem": {"type": "object", "required": ["type", "title", "status", "detail", "instance"], "properties": {"type": {"type": "string"}, "title": {"type": "string"},
  "status": {"type": "integer"}, "detail": {"type": "string"}, "instance": {"type": "string"}, "errors": {"type": "array", "items": {"$ref": "#/components/schemas/FieldError"}},
  "refusals": {"type": "array", "items": {"type": "string"}, "description": "Names of the refusal table, see /api/v1/faults"}}, "additionalProperties": false},
"Done": {"type": "object", "required": ["ok"], "properties": {"ok": {"const": true}}, "additionalProperties": false},
"DoneStored": {"type": "object", "required": ["ok", "stored"], "properties": {"ok": {"const": true}, "stored": {"$ref": "#/components/schemas/Stored"}},
  "additionalProperties": false},
"Stored": {"type": "boolean", "description": "true: on the disk, file and folder synced. false: in force and not stored; see the notices of /api/v1/status"},
"Status": {"type": "object", "required": ["hoist_id", "version", "started", "simulated", "scenario", "core", "recording", "notices", "lease", "clients", "counters", "server"], "properties": {
  "hoist_id": {"type": ["string", "null"], "description": "UUID of this hoist, whatever it is called; null: the recordings file is not open"},
  "version": {"type": "string"}, "started": {"type": "string"}, "simulated": {"type": "boolean"}, "scenario": {"type": ["string", "null"]},
  "core": {"type": "object", "required": ["connected", "version", "problem", "mode", "faults", "alarms", "blocked", "standing_still", "tick", "bus"], "properties": {"connected": {"type": "boolean"},
    "version": {"type": ["string", "null"], "description": "Of hoist-control: version and commit; null before one was connected"},
    "problem": {"type": ["string", "null"]}, "mode": {"type": ["string", "null"]}, "faults": {"type": "array", "items": {"type": "string"}},
    "alarms": {"type": "array", "items": {"$ref": "#/components/schemas/Alarm"}, "description": "The faults in the order in which to tell them: what endangers the patient, what stopped the hoist, each followed by its consequences"}, "blocked": {"type": "array", "items": {"type": "string"}},
    "standing_still": {"type": ["boolean", "null"]}, "tick": {"type": ["integer", "null"]},
    "bus": {"type": ["object", "null"], "required": ["frames", "refused"], "properties": {"frames": {"type": "integer"}, "refused": {"type": "integer"}}}}, "additionalProperties": false},
  "recording": {"$ref": "#/components/schemas/Recording"}, "notices": {"type": "array", "items": {"$ref": "#/components/schemas/StandingNotice"}},
  "lease": {"$ref": "#/components/schemas/Lease"},
  "clients": {"type": "integer"}, "counters": {"type": "object", "additionalProperties": {"type": "integer"}},
  "server": {"type": "object", "required": ["uptime_s", "layout_hash"], "properties": {"uptime_s": {"type": "number"}, "layout_hash": {"type": "string"}}, "additionalProperties": false}},
  "additionalProperties": false},
"StandingNotice": {"type": "object", "required": ["name", "priority", "text", "action", "detail"], "description": "Stays as long as its condition holds", "properties": {
  "name": {"type": "string"}, "priority": {"enum": ["low", "medium"]}, "text": {"$ref": "#/components/schemas/Words"}, "action": {"$ref": "#/components/schemas/Words"},
  "detail": {"type": "string", "description": "For the engineer"}}, "additionalProperties": false},
"Alarm": {"type": "object", "required": ["name", "code", "text", "action", "consequence_of"], "properties": {"name": {"type": "string"},
  "code": {"type": "integer", "description": "What it is about: of a drive its emergency code; 0 = nothing more is known"},
  "text": {"$ref": "#/components/schemas/Words"}, "action": {"$ref": "#/components/schemas/Words"},
  "consequence_of": {"type": ["string", "null"], "description": "The fault that explains it"}}, "additionalProperties": false},
"Emergency": {"type": "object", "required": ["code", "name", "text", "detail"], "properties": {"code": {"type": "integer"}, "name": {"type": "string"},
  "text": {"$ref": "#/components/schemas/Words"}, "detail": {"$ref": "#/components/schemas/Words"}}, "additionalProperties": false},
"NodeHealth": {"type": "object", "required": ["name", "id", "state", "age_s", "heartbeats_missed", "nmt_state", "lost_frames", "lost_10s", "error_register", "emergencies",
  "latest_emergency"], "properties": {"name": {"type": "string"}, "id": {"type": "integer"},
  "state": {"enum": ["working", "losing", "waiting", "silent"], "description": "losing: frames were lost in the last ten seconds; waiting: it lives and is not started yet"},
  "age_s": {"type": ["number", "null"], "description": "Since its latest process data; null = longer than 2.5 s or never"}, "heartbeats_missed": {"type": "integer"},
  "nmt_state": {"type": ["integer", "null"]}, "lost_frames": {"type": "integer"}, "lost_10s": {"type": "integer"}, "error_register": {"type": "integer"},
  "emergencies": {"type": "integer"}, "latest_emergency": {"anyOf": [{"$ref": "#/components/schemas/Emergency"}, {"type": "null"}]}}, "additionalProperties": false},
"BusHealth": {"type": "object", "required": ["up", "state", "load_norm", "frames_per_s", "received", "refused", "send_refused", "reopened", "overflows", "errors", "tx_errors",
  "rx_errors", "syncs_lost", "duplicate_id", "babbling_id"], "properties": {"up": {"type": "boolean"}, "state": {"enum": ["active", "warning", "passive", "off"]},
  "load_norm": {"type": "number", "description": "Counted with the most stuff bits: at most 18 % of itself too high"}, "frames_per_s": {"type": "integer"},
  "received": {"type": "integer"}, "refused": {"type": "integer"}, "send_refused": {"type": "integer"}, "reopened": {"type": "integer"}, "overflows": {"type": "integer"},
  "errors": {"type": "integer"}, "tx_errors": {"type": "integer"}, "rx_errors": {"type": "integer"}, "syncs_lost": {"type": "integer"},
  "duplicate_id": {"type": ["integer", "null"], "description": "Node id under which two devices answer; 127 = a second control computer"},
  "babbling_id": {"type": ["integer", "null"], "description": "CAN id that comes far more often than planned"}}, "additionalProperties": false},
"RecordingsHealth": {"type": "object", "required": ["state", "progress", "checked_utc_ms", "damaged_blobs", "damaged_sessions", "detail"], "properties": {
  "state": {"enum": ["unchecked", "checking", "sound", "damaged"], "description": "Of the file in use. It is checked after each start; the job integrity_check does it again"},
  "progress": {"type": "number", "minimum": 0, "maximum": 1, "description": "While checking"}, "checked_utc_ms": {"type": ["integer", "null"]},
  "damaged_blobs": {"type": "integer"}, "damaged_sessions": {"type": "array", "items": {"type": "integer"}, "description": "Parts of these cannot be read"},
  "detail": {"type": "string", "description": "What is damaged, or why it could not be checked; for the engineer"}}, "additionalProperties": false},
"JobRequest": {"description": "What to do", "anyOf": [
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "integrity_check"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "recompute_metrics"}, "sessions": {"type": "array", "minItems": 1, "maxItems": 1000,
   "items": {"type": "integer", "minimum": 1, "maximum": 9007199254740991}, "description": "The newest 1000 when not given"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "backup"}, "folder": {"type": "string", "minLength": 1, "maxLength": 1000,
    "description": "One of the allowed folders (list_backups) or a folder in one; the first when not given"},
   "identity_key": {"type": "boolean", "description": "true: the key of the sealed names goes with it. Who has such a backup can read them"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind", "backup"], "properties": {"kind": {"const": "restore"}, "backup": {"type": "string", "minLength": 1, "maxLength": 1000,
    "description": "As list_backups names it"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "export_sessions"},
   "layout": {"enum": ["files", "bids", "sqlite", "reports"],
    "description": "files (when not given): a folder per session; bids: a data set as Motion-BIDS lays it out, without notes and user names; sqlite: one SQLite file with plain tables; reports: pages for print of at most 1000 sessions, and one of all"},
   "report": {"enum": ["patient", "full"], "description": "Of the layout reports: one page in plain words, or full (when not given)"},
   "language": {"enum": ["en", "de"], "description": "Of the layout reports; en when not given"},
   "sessions": {"type": "array", "minItems": 1, "maxItems": 10000, "items": {"type": "integer", "minimum": 1, "maximum": 9007199254740991}, "description": "These only; the filters do not count"},
   "subject": {"type": "string", "minLength": 1, "maxLength": 64, "description": "The whole patient code"},
   "from_day": {"type": "string", "minLength": 10, "maxLength": 10, "description": "YYYY-MM-DD"}, "to_day": {"type": "string", "minLength": 10, "maxLength": 10, "description": "YYYY-MM-DD"},
   "exercise": {"type": "string", "minLength": 1, "maxLength": 64, "description": "Its shape"}, "visit": {"type": "integer", "minimum": 1, "maximum": 9007199254740991},
   "tag": {"type": "string", "minLength": 1, "maxLength": 64, "description": "A word of the session's note that begins with #, without the #"},
   "simulated": {"type": "boolean", "description": "false: without recordings of a simulated hoist"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "list_backups"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind", "rule"], "properties": {"kind": {"const": "preview_retention"}, "rule": {"$ref": "#/components/schemas/RetentionRule"}},
   "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "retention"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind", "subjects", "seed"], "properties": {"kind": {"const": "study"},
   "subjects": {"type": "integer", "minimum": 1, "maximum": 99, "description": "Virtual subjects; the paper had 11"},
   "seed": {"type": "integer", "minimum": 0, "maximum": 1000000000, "description": "The same seed gives the same subjects and runs"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind"], "properties": {"kind": {"const": "study_recorded"},
   "subject": {"type": "string", "minLength": 1, "maxLength": 64, "description": "The whole patient code"},
   "from_day": {"type": "string", "minLength": 10, "maxLength": 10, "description": "YYYY-MM-DD"}, "to_day": {"type": "string", "minLength": 10, "maxLength": 10, "description": "YYYY-MM-DD"},
   "simulated": {"type": "boolean", "description": "false: without recordings of a simulated hoist"}}, "additionalProperties": false},
  {"type": "object", "required": ["kind", "study"], "properties": {"kind": {"const": "delete_study"}, "study": {"type": "integer", "minimum": 1, "maximum": 9007199254740991}},
   "additionalProperties": false}]},
"StudyRun": {"type": "object", "description": "Which run of a study with virtual subjects a session is", "required": ["study", "subject", "run"], "properties": {
  "study": {"type": "integer"}, "subject": {"type": "string"}, "run": {"type": "integer", "description": "Its number in the protocol"}}, "additionalProperties": false},
"StudyJobResult": {"type": "object", "required": ["kind", "study"], "properties": {"kind": {"enum": ["study", "study_recorded"]}, "study": {"type": "integer"}}, "additionalProperties": false},
"StudyDeleted": {"type": "object", "required": ["kind", "study", "sessions"], "properties": {"kind": {"const": "delete_study"}, "study": {"type": "integer"},
  "sessions": {"type": "integer"}}, "additionalProperties": false},
"StudyList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "description": "Newest first", "items": {"type": "object",
  "required": ["id", "made_utc_ms", "title", "subjects", "seed", "sessions"], "properties": {"id": {"type": "integer"}, "made_utc_ms": {"type": "integer"}, "title": {"type": "string"},
  "subjects": {"type": "integer"}, "seed": {"type": ["integer", "null"]}, "sessions": {"type": "integer", "description": "That are still there"}}, "additionalProperties": false}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"Study": {"type": "object", "required": ["id", "made_utc_ms", "sessions", "drawings", "report"], "properties": {"id": {"type": "integer"}, "made_utc_ms": {"type": "integer"},
  "sessions": {"type": "array", "description": "Its runs that are still there", "items": {"type": "object", "required": ["session", "subject", "run"], "properties": {"session": {"type": "integer"},
   "subject": {"type": "string"}, "run": {"type": "integer"}}, "additionalProperties": false}},
  "drawings": {"type": "array", "description": "Figures 2, 7 and 8 of the paper by name: /api/v1/studies/{id}/drawings/{name}", "items": {"type": "string"}},
  "report": {"$ref": "#/components/schemas/StudyReport"}}, "additionalProperties": false},
"StudyColumn": {"type": "array", "description": "null: no value", "items": {"type": ["number", "null"]}},
"StudyColumns": {"type": "array", "description": "By run, then by row", "items": {"$ref": "#/components/schemas/StudyColumn"}},
"StudyTest": {"type": "object", "description": "Wilcoxon's signed ranks, two-sided, exact, of the subjects who did both runs", "required": ["pairs", "up", "down", "mean_first", "mean_second", "p"],
  "properties": {"pairs": {"type": "integer"}, "up": {"type": "integer"}, "down": {"type": "integer"}, "mean_first": {"type": "number"}, "mean_second": {"type": "number"},
  "p": {"type": ["number", "null"]}}, "additionalProperties": false},
"StudyReport": {"type": "object", "description": "What `hoist study` prints, as numbers", "required": ["title", "virtual_subjects", "subjects", "seed", "preset", "laps", "runs", "tables", "compared", "others", "findings", "assumed", "left_out"],
  "properties": {"title": {"type": "string"}, "virtual_subjects": {"type": "boolean"}, "subjects": {"type": "integer"}, "seed": {"type": ["integer", "null"]}, "preset": {"type": "string"}, "laps": {"type": "number"},
  "runs": {"type": "array", "items": {"type": "object", "required": ["run", "shape", "led_by", "injured"], "properties": {"run": {"type": "integer"}, "shape": {"enum": ["square", "eight"]},
   "led_by": {"enum": ["patient", "therapist"]}, "injured": {"type": "boolean", "description": "With the orthosis that simulates an injury"}}, "additionalProperties": false}},
  "tables": {"type": "array", "description": "Tables II (C) and III (J_N)", "items": {"type": "object", "required": ["figure", "decimals", "subjects", "own", "paper", "own_mean", "paper_mean"], "properties": {
   "figure": {"enum": ["C", "J_N"]}, "decimals": {"type": "integer"}, "subjects": {"type": "array", "description": "Of the rows; - where only the paper has one", "items": {"type": "string"}},
   "own": {"$ref": "#/components/schemas/StudyColumns"}, "paper": {"$ref": "#/components/schemas/StudyColumns"},
   "own_mean": {"$ref": "#/components/schemas/StudyColumn"}, "paper_mean": {"$ref": "#/components/schemas/StudyColumn"}}, "additionalProperties": false}},
  "compared": {"type": "array", "items": {"type": "object", "required": ["figure", "from", "to", "decimals", "own", "paper"], "properties": {"figure": {"enum": ["C", "J_N"]}, "from": {"type": "integer"},
   "to": {"type": "integer"}, "decimals": {"type": "integer"}, "own": {"$ref": "#/components/schemas/StudyTest"}, "paper": {"$ref": "#/components/schemas/StudyTest"}}, "additionalProperties": false}},
  "others": {"type": "array", "description": "Means of other figures, by run", "items": {"type": "object", "required": ["figure", "means"], "properties": {
   "figure": {"enum": ["C_best", "rms_position_m", "rms_heading_rad", "walking_speed_m_s", "lap_time_mean_s"]}, "means": {"$ref": "#/components/schemas/StudyColumn"}}, "additionalProperties": false}},
  "findings": {"type": "object", "description": "What comes out by itself: mean C of the squares, of the eights that the patient leads, and J_N of squares by that of the therapist's eights",
   "required": ["c_square", "c_led", "j_ratio"], "properties": {"c_square": {"type": ["number", "null"]}, "c_led": {"type": ["number", "null"]}, "j_ratio": {"type": ["number", "null"]}}, "additionalProperties": false},
  "assumed": {"anyOf": [{"$ref": "#/components/schemas/StudyAssumed"}, {"type": "null"}], "description": "What is put in for virtual subjects: no finding. null: they were people"},
  "left_out": {"type": "array", "description": "Runs that do not count, and why", "items": {"type": "object", "required": ["subject", "run", "figure", "reason_code", "laps"], "properties": {"subject": {"type": "string"},
   "run": {"type": "integer"}, "figure": {"type": ["string", "null"], "description": "That is not valid; null: too few laps"}, "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoFigure"}, {"type": "null"}]},
   "laps": {"type": ["number", "null"], "description": "Walked, when they are too few"}}, "additionalProperties": false}}}, "additionalProperties": false},
"StudyAssumed": {"type": "object", "required": ["wish_m_s", "anticipation_norm", "learning_norm", "trailing_s", "limp_norm", "injured_sway_norm", "therapist_m_s", "therapist_delay_s", "misjudgement_m", "misjudgement_rad"],
  "properties": {"wish_m_s": {"$ref": "#/components/schemas/StudyRange"}, "anticipation_norm": {"$ref": "#/components/schemas/StudyRange"}, "learning_norm": {"type": "number"}, "trailing_s": {"type": "number"},
  "limp_norm": {"type": "number"}, "injured_sway_norm": {"type": "number"}, "therapist_m_s": {"type": "number"}, "therapist_delay_s": {"type": "number"}, "misjudgement_m": {"type": "number"},
  "misjudgement_rad": {"type": "number"}}, "additionalProperties": false},
"StudyRange": {"type": "array", "minItems": 2, "maxItems": 2, "items": {"type": "number"}},
"RetentionRule": {"type": "object", "description": "Off while both numbers are null", "required": ["days", "disk_percent", "needs_backup"], "properties": {
  "days": {"type": ["integer", "null"], "minimum": 30, "maximum": 36500, "description": "A session is deleted when it is older"},
  "disk_percent": {"type": ["integer", "null"], "minimum": 5, "maximum": 90, "description": "The oldest sessions are deleted while the recordings take more of their disk"},
  "needs_backup": {"type": "boolean", "description": "true: only sessions that a checked backup holds are deleted"}}, "additionalProperties": false},
"Retention": {"type": "object", "required": ["days", "disk_percent", "needs_backup", "etag"], "properties": {"days": {"type": ["integer", "null"]},
  "disk_percent": {"type": ["integer", "null"]}, "needs_backup": {"type": "boolean"}, "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"Job": {"type": "object", "required": ["id", "kind", "state", "progress", "actor", "asked_utc_ms", "ended_utc_ms", "detail", "reason_code"], "properties": {
  "id": {"type": "integer"}, "kind": {"$ref": "#/components/schemas/JobKind"}, "state": {"enum": ["waiting", "running", "done", "failed", "cancelled"]},
  "progress": {"type": "number", "minimum": 0, "maximum": 1}, "actor": {"$ref": "#/components/schemas/ActorOrNull"},
  "asked_utc_ms": {"type": "integer"}, "ended_utc_ms": {"type": ["integer", "null"]}, "detail": {"type": "string", "description": "Why it failed"},
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/ReasonCode"}, {"type": "null"}], "description": "The same for programs"},
  "result": {"anyOf": [{"$ref": "#/components/schemas/IntegrityResult"}, {"$ref": "#/components/schemas/MetricsResult"}, {"$ref": "#/components/schemas/BackupResult"}, {"$ref": "#/components/schemas/RestoreResult"},
   {"$ref": "#/components/schemas/BackupsResult"}, {"$ref": "#/components/schemas/ExportResult"}, {"$ref": "#/components/schemas/RetentionResult"}, {"$ref": "#/components/schemas/StudyJobResult"},
   {"$ref": "#/components/schemas/StudyDeleted"}, {"type": "null"}], "description": "Not in lists; null until it is done"}},
  "additionalProperties": false},
"JobList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Job"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"ExportResult": {"type": "object", "required": ["kind", "sessions", "bytes", "file_name"], "properties": {"kind": {"const": "export_sessions"}, "sessions": {"type": "integer"},
  "bytes": {"type": "integer"}, "file_name": {"type": "string"}}, "additionalProperties": false},
"IntegrityResult": {"type": "object", "required": ["kind", "sound", "structure", "blobs", "damaged_blobs", "damaged_sessions"], "properties": {"kind": {"const": "integrity_check"},
  "sound": {"type": "boolean"}, "structure": {"type": "array", "maxItems": 10, "items": {"type": "string"}, "description": "Damaged pages, tables and indexes: the file is set aside and a new one begun"},
  "blobs": {"type": "integer", "description": "Stored blobs that were looked at; 0 when the structure is damaged"},
  "damaged_blobs": {"type": "integer"}, "damaged_sessions": {"type": "array", "items": {"type": "integer"}}}, "additionalProperties": false},
"MetricsResult": {"type": "object", "required": ["kind", "items", "failed"], "properties": {"kind": {"const": "recompute_metrics"},
  "items": {"type": "array", "items": {"$ref": "#/components/schemas/Metrics"}}, "failed": {"type": "array", "items": {"type": "object", "required": ["session", "detail"],
  "properties": {"session": {"type": "integer"}, "detail": {"type": "string"}}, "additionalProperties": false}}}, "additionalProperties": false},
"BackupFile": {"type": "object", "required": ["name", "bytes", "sha256"], "properties": {"name": {"type": "string"}, "bytes": {"type": "integer"}, "sha256": {"type": "string"}},
  "additionalProperties": false},
"Backup": {"type": "object", "required": ["backup", "device", "hoist_id", "program", "utc_ms", "sessions", "files"], "properties": {"backup": {"type": "string", "description": "Its folder"},
  "device": {"type": "string", "description": "Name of the computer"},
  "hoist_id": {"$ref": "#/components/schemas/BackupHoist"}, "program": {"type": "string"}, "utc_ms": {"type": "integer"}, "sessions": {"type": "integer"},
  "files": {"type": "array", "items": {"$ref": "#/components/schemas/BackupFile"}}}, "additionalProperties": false},
"BackupHoist": {"type": ["string", "null"], "description": "UUID of the hoist; null: from before hoists had an id. A restore leaves the id of the hoist as it is"},
"BackupResult": {"type": "object", "required": ["kind", "backup", "device", "hoist_id", "program", "utc_ms", "sessions", "files"], "properties": {"kind": {"const": "backup"},
  "backup": {"type": "string"}, "device": {"type": "string"}, "hoist_id": {"$ref": "#/components/schemas/BackupHoist"}, "program": {"type": "string"},
  "utc_ms": {"type": "integer"}, "sessions": {"type": "integer"},
  "files": {"type": "array", "items": {"$ref": "#/components/schemas/BackupFile"}}}, "additionalProperties": false},
"RestoreResult": {"type": "object", "required": ["kind", "backup", "set_aside"], "properties": {"kind": {"const": "restore"}, "backup": {"type": "string"},
  "set_aside": {"type": "string", "description": "Where the file is that was in use before"}}, "additionalProperties": false},
"RetentionResult": {"type": "object", "required": ["kind", "rule", "sessions", "bytes", "from_utc_ms", "to_utc_ms", "without_backup", "used_bytes", "disk_bytes", "excess_bytes"],
  "properties": {"kind": {"enum": ["preview_retention", "retention"]}, "rule": {"$ref": "#/components/schemas/RetentionRule"},
  "sessions": {"type": "integer", "description": "That would be deleted, or were"}, "bytes": {"type": "integer", "description": "That these take"},
  "from_utc_ms": {"type": ["integer", "null"], "description": "Earliest start of them"}, "to_utc_ms": {"type": ["integer", "null"], "description": "Latest start of them"},
  "without_backup": {"type": "integer", "description": "Further sessions, which are kept because no checked backup holds them"},
  "used_bytes": {"type": "integer", "description": "What the recordings took before"}, "disk_bytes": {"type": "integer", "description": "Size of their disk"},
  "excess_bytes": {"type": "integer", "description": "By which they still exceed their share afterwards; the rest is protected"}}, "additionalProperties": false},
"BackupsResult": {"type": "object", "required": ["kind", "folders", "items"], "properties": {"kind": {"const": "list_backups"},
  "folders": {"type": "array", "description": "The allowed ones (--backup-root)", "items": {"type": "object", "required": ["folder", "there", "free_bytes"],
   "properties": {"folder": {"type": "string"}, "there": {"type": "boolean"}, "free_bytes": {"type": ["integer", "null"]}}, "additionalProperties": false}},
  "items": {"type": "array", "items": {"$ref": "#/components/schemas/Backup"}}}, "additionalProperties": false},
"Health": {"type": "object", "required": ["connected", "nodes", "bus", "emergencies", "recordings"], "properties": {"connected": {"type": "boolean"}, "recordings": {"$ref": "#/components/schemas/RecordingsHealth"},
  "nodes": {"type": "array", "items": {"$ref": "#/components/schemas/NodeHealth"}, "description": "Empty while the core is not connected"},
  "bus": {"anyOf": [{"$ref": "#/components/schemas/BusHealth"}, {"type": "null"}]},
  "emergencies": {"type": "array", "description": "The latest 64, newest first", "items": {"type": "object", "required": ["node", "time_ns", "age_s", "error_register", "emergency"],
    "properties": {"node": {"type": "string"}, "time_ns": {"type": "integer"}, "age_s": {"type": "number"}, "error_register": {"type": "integer"},
    "emergency": {"$ref": "#/components/schemas/Emergency"}}, "additionalProperties": false}}}, "additionalProperties": false},
"LatenessBuckets": {"type": "array", "description": "Those that hold something, earliest first", "items": {"type": "object", "required": ["from_s", "to_s", "count"],
  "properties": {"from_s": {"type": "number"}, "to_s": {"type": ["number", "null"]}, "count": {"type": "integer"}}, "additionalProperties": false}},
"Tools": {"type": "object", "required": ["enabled", "foxglove", "rosbridge", "foxglove_layout", "etag"], "properties": {"enabled": {"type": "boolean"}, "etag": {"$ref": "#/components/schemas/EditTag"},
  "foxglove": {"type": "string", "description": "Path of the WebSocket"}, "rosbridge": {"type": "string", "description": "Path of the WebSocket"},
  "foxglove_layout": {"type": "string", "description": "Path of a layout file for Foxglove Studio"}}, "additionalProperties": false},
"ToolsRequest": {"type": "object", "required": ["enabled"], "properties": {"enabled": {"type": "boolean"}}, "additionalProperties": false},
"Loop": {"type": "object", "required": ["steps", "missed", "late", "lateness_p50_s", "lateness_p99_s", "lateness_max_s", "latest_ever_s", "longest_step_s", "page_faults",
  "allocations", "priority", "cpu", "memory_locked", "lately", "ever"], "properties": {"steps": {"type": "integer"},
  "missed": {"type": "integer", "description": "Steps that did not take place because one before them began or ended too late"},
  "late": {"type": "integer", "description": "Steps that began more than 2 ms late"}, "lateness_p50_s": {"type": "number"}, "lateness_p99_s": {"type": "number"},
  "lateness_max_s": {"type": "number"}, "latest_ever_s": {"type": "number"}, "longest_step_s": {"type": "number"}, "page_faults": {"type": "integer"},
  "allocations": {"type": "integer"}, "priority": {"type": ["integer", "null"], "description": "Under SCHED_FIFO; null = not granted"},
  "cpu": {"type": ["integer", "null"], "description": "Core that the control thread is bound to"}, "memory_locked": {"type": "boolean"},
  "lately": {"$ref": "#/components/schemas/LatenessBuckets"}, "ever": {"$ref": "#/components/schemas/LatenessBuckets"}}, "additionalProperties": false},
"SignalList": {"type": "object", "required": ["record_bytes", "items"], "properties": {"record_bytes": {"type": "integer"}, "items": {"type": "array", "items": {"type": "object",
  "required": ["id", "name", "unit", "type", "lsb", "offset", "title", "doc"], "properties": {"id": {"type": "integer"}, "name": {"type": "string"}, "unit": {"type": "string"},
  "type": {"enum": ["u64", "u32", "i32", "f32", "u16", "u8"]}, "lsb": {"type": "number"}, "offset": {"type": "integer"}, "title": {"$ref": "#/components/schemas/Words"},
  "doc": {"type": "string"}}, "additionalProperties": false}}}, "additionalProperties": false},
"FaultList": {"type": "object", "required": ["items", "refusals"], "properties": {"items": {"type": "array", "items": {"type": "object",
  "required": ["bit", "name", "priority", "reaction", "hazard", "text", "action"], "properties": {"bit": {"type": "integer"}, "name": {"type": "string"},
  "priority": {"enum": ["low", "medium", "high"]}, "reaction": {"enum": ["warn", "soft_stop", "protective_stop", "out_of_service", "power_off"]}, "hazard": {"type": "string"},
  "text": {"$ref": "#/components/schemas/Words"}, "action": {"$ref": "#/components/schemas/Words"}}, "additionalProperties": false}},
  "refusals": {"type": "array", "items": {"type": "object", "required": ["bit", "name", "text"], "properties": {"bit": {"type": "integer"}, "name": {"type": "string"},
  "text": {"$ref": "#/components/schemas/Words"}}, "additionalProperties": false}}}, "additionalProperties": false},
"ModeList": {"type": "object", "required": ["items"], "properties": {"items": {"type": "array", "items": {"type": "object", "required": ["value", "name", "moving", "title"],
  "properties": {"value": {"type": "integer"}, "name": {"type": "string"}, "moving": {"type": "boolean"}, "title": {"$ref": "#/components/schemas/Words"}}, "additionalProperties": false}}},
  "additionalProperties": false},
"Parameter": {"type": "object", "required": ["id", "name", "unit", "value", "default", "min", "max", "edit", "scope", "role", "source", "title", "effect"], "properties": {
  "id": {"type": "integer"}, "name": {"$ref": "#/components/schemas/ParamName"}, "unit": {"type": "string"}, "value": {"type": "number"}, "default": {"type": "number"}, "min": {"type": "number"},
  "max": {"type": "number"}, "edit": {"enum": ["live", "stopped"]}, "scope": {"enum": ["core", "drive", "tilt"]}, "role": {"enum": ["viewer", "therapist", "engineer"]},
  "source": {"type": "string"}, "title": {"$ref": "#/components/schemas/Words"}, "effect": {"$ref": "#/components/schemas/Words"}}, "additionalProperties": false},
"ParameterList": {"type": "object", "required": ["version", "items"], "properties": {"version": {"type": "integer", "description": "Rises with each change; each run of the core begins at another number"}, "items": {"type": "array",
  "items": {"$ref": "#/components/schemas/Parameter"}}}, "additionalProperties": false},
"ParameterValue": {"type": "object", "required": ["value"], "properties": {"value": {"type": "number"}, "revert_after_s": {"$ref": "#/components/schemas/TrialTime"}}, "additionalProperties": false},
"ParameterValues": {"type": "object", "minProperties": 1, "properties": {"revert_after_s": {"$ref": "#/components/schemas/TrialTime"}}, "additionalProperties": {"type": "number"}, "description": "Names and new values"},
"ParameterResult": {"type": "object", "required": ["version", "values", "stored"], "properties": {"version": {"type": "integer"}, "values": {"type": "object",
  "additionalProperties": {"type": "number"}}, "stored": {"$ref": "#/components/schemas/Stored"}}, "additionalProperties": false},
"PresetList": {"type": "object", "required": ["items"], "properties": {"items": {"type": "array", "items": {"type": "object", "required": ["name", "title", "doc", "values"],
  "properties": {"name": {"type": "string"}, "title": {"$ref": "#/components/schemas/Words"}, "doc": {"$ref": "#/components/schemas/Words"},
  "values": {"type": "object", "additionalProperties": {"type": "number"}}}, "additionalProperties": false}}}, "additionalProperties": false},
"ExerciseSize": {"type": "object", "required": ["name", "title", "doc", "required", "usual_m", "least_m", "most_m", "driven_least_m", "driven_most_m", "share"], "properties": {
  "name": {"type": "string"}, "title": {"$ref": "#/components/schemas/Words"}, "doc": {"type": "string"}, "required": {"type": "boolean"},
  "usual_m": {"type": "number", "description": "0 = left out"}, "least_m": {"type": "number"}, "most_m": {"type": "number"},
  "driven_least_m": {"type": "number", "description": "Where the hoist drives by itself"}, "driven_most_m": {"type": "number"},
  "share": {"type": "number", "description": "At most this share of the shape's first size; 0 = no such limit"}}, "additionalProperties": false},
"ExerciseList": {"type": "object", "required": ["items"], "properties": {"items": {"type": "array", "items": {"type": "object",
  "required": ["shape", "title", "turned", "closed", "sizes"], "properties": {"shape": {"type": "string"}, "title": {"$ref": "#/components/schemas/Words"},
  "turned": {"type": "boolean", "description": "May be walked clockwise too"}, "closed": {"type": "boolean", "description": "May have laps"},
  "sizes": {"type": "array", "items": {"$ref": "#/components/schemas/ExerciseSize"}}}, "additionalProperties": false}}}, "additionalProperties": false},
"GuidedPathOrNull": {"anyOf": [{"$ref": "#/components/schemas/GuidedPath"}, {"type": "null"}]},
"ExerciseOrNull": {"anyOf": [{"$ref": "#/components/schemas/Exercise"}, {"type": "null"}]},
"TaskRange": {"type": "object", "required": ["usual", "least", "most", "step"], "properties": {"usual": {"type": "number"}, "least": {"type": "number"},
  "most": {"type": "number"}, "step": {"type": "number", "minimum": 0, "description": "Of a button"}}, "additionalProperties": false},
"TaskEnd": {"type": "string", "enum": ["distance", "time", "turn", "back", "hand"], "description": "What ends it: so many times along its line, seconds since the first movement, radians turned, metres away and back, or the therapist"},
"Task": {"type": "object", "description": "A clinical task: a file of db/tasks", "required": ["name", "version", "title", "instruction", "line", "sizes", "leads", "ends", "edge_m",
  "repetitions", "rest_s", "results"], "properties": {"name": {"type": "string", "minLength": 1, "maxLength": 64}, "version": {"type": "integer", "minimum": 1},
  "title": {"$ref": "#/components/schemas/Words"}, "instruction": {"$ref": "#/components/schemas/Words", "description": "What the patient is told"},
  "line": {"type": ["string", "null"], "description": "Shape of its exercise; null = without a line"},
  "sizes": {"type": "object", "additionalProperties": {"$ref": "#/components/schemas/TaskRange"}, "description": "Sizes that may be adjusted, m; the others keep their proportion"},
  "leads": {"type": "array", "minItems": 1, "items": {"enum": ["user", "remote", "guided"]}, "description": "Modes in which it may be done"},
  "ends": {"type": "object", "required": ["by", "goal"], "properties": {"by": {"$ref": "#/components/schemas/TaskEnd"}, "goal": {"$ref": "#/components/schemas/TaskRange"}},
    "additionalProperties": false}, "edge_m": {"type": "number", "minimum": 0, "description": "At both ends of the line, walked but not timed"},
  "repetitions": {"$ref": "#/components/schemas/TaskRange"}, "rest_s": {"$ref": "#/components/schemas/TaskRange"},
  "results": {"type": "array", "minItems": 1, "items": {"type": "string"}, "description": "Figures of a session that are its results"}}, "additionalProperties": false},
"TaskList": {"type": "object", "required": ["items"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Task"}}}, "additionalProperties": false},
"TaskRequest": {"type": "object", "required": ["task"], "properties": {"task": {"type": ["string", "null"], "minLength": 1, "maxLength": 64, "description": "null: no task, only the exercise"},
  "sizes": {"type": ["object", "null"], "maxProperties": 4, "additionalProperties": {"type": "number"}}, "clockwise": {"type": ["boolean", "null"]},
  "goal": {"type": ["number", "null"], "description": "Of its end: times along the line, seconds, radians, metres"}, "repetitions": {"type": ["number", "null"]}, "rest_s": {"type": ["number", "null"]},
  "line": {"anyOf": [{"$ref": "#/components/schemas/LineRequest"}, {"type": "null"}], "description": "Of the task own_line: what is walked, and what it is called"}},
  "additionalProperties": false, "description": "What is left out is as usual"},
"RehearsalRequest": {"type": "object", "required": ["rehearsal"], "properties": {"rehearsal": {"anyOf": [{"$ref": "#/components/schemas/RehearsalKind"}, {"type": "null"}], "description": "null: none"},
  "seed": {"type": ["integer", "null"], "minimum": 0, "maximum": 1000000000, "description": "Draws the moment when it happens; a new one when not given"}}, "additionalProperties": false},
"RehearsalLook": {"type": "object", "required": ["check", "limit_s"], "properties": {"check": {"$ref": "#/components/schemas/RehearsalCheck"}, "limit_s": {"type": ["number", "null"], "description": "null: none"}}, "additionalProperties": false},
"RehearsalItem": {"type": "object", "required": ["check", "limit_s", "seen", "after_s"], "properties": {"check": {"$ref": "#/components/schemas/RehearsalCheck"}, "limit_s": {"type": ["number", "null"]},
  "seen": {"enum": ["good", "wrong", "missing"], "description": "missing: it was not done"}, "after_s": {"type": ["number", "null"], "description": "When it was done, since what happened; of look: how long"}}, "additionalProperties": false},
"RehearsalResult": {"type": "object", "description": "What staff did in a rehearsal on a simulated hoist", "required": ["rehearsal", "seed", "after_s", "items"], "properties": {"rehearsal": {"$ref": "#/components/schemas/RehearsalKind"},
  "seed": {"type": "integer"}, "after_s": {"type": "number", "description": "Of walking, when it happened"}, "items": {"type": "array", "items": {"$ref": "#/components/schemas/RehearsalItem"}}}, "additionalProperties": false},
"RehearsalState": {"type": "object", "required": ["reason_code", "kinds", "phase", "rehearsal", "seed", "session", "result"], "properties": {
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/ReasonCode"}, {"type": "null"}], "description": "Why none can be chosen here; null: one can"},
  "kinds": {"type": "array", "items": {"type": "object", "required": ["rehearsal", "looks"], "properties": {"rehearsal": {"$ref": "#/components/schemas/RehearsalKind"},
    "looks": {"type": "array", "items": {"$ref": "#/components/schemas/RehearsalLook"}}}, "additionalProperties": false}},
  "phase": {"enum": ["none", "waiting", "happening", "over", "lost"], "description": "lost: the core ended, so there is no result"}, "rehearsal": {"anyOf": [{"$ref": "#/components/schemas/RehearsalKind"}, {"type": "null"}]}, "seed": {"type": ["integer", "null"]},
  "session": {"type": ["integer", "null"], "description": "That was recorded when it happened; its markers have the result"},
  "result": {"anyOf": [{"$ref": "#/components/schemas/RehearsalResult"}, {"type": "null"}], "description": "When it is over"}}, "additionalProperties": false},
"LineName": {"type": "string", "minLength": 1, "maxLength": 64, "description": "One line, at most 64 bytes of UTF-8; of a place, never of a patient"},
"LineRequest": {"type": "object", "required": ["name", "exercise"], "properties": {"name": {"$ref": "#/components/schemas/LineName"},
  "exercise": {"$ref": "#/components/schemas/Exercise", "description": "Of the shape own"}}, "additionalProperties": false},
"LinePatch": {"type": "object", "minProperties": 1, "properties": {"name": {"$ref": "#/components/schemas/LineName"},
  "exercise": {"$ref": "#/components/schemas/Exercise", "description": "Of the shape own"}}, "additionalProperties": false},
"Line": {"type": "object", "required": ["id", "name", "version", "saved_utc_ms", "exercise", "length_m", "etag"], "properties": {"id": {"type": "integer"}, "name": {"type": "string"},
  "version": {"type": "integer", "description": "Counts the savings"}, "saved_utc_ms": {"type": "integer"}, "exercise": {"$ref": "#/components/schemas/Exercise"},
  "length_m": {"type": "number", "description": "Once along it, with its round corners"}, "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"LineList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Line"}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"TaskState": {"type": "object", "required": ["task", "version", "ends", "goal", "repetitions", "rest_s", "repetition", "begun_tick", "reached", "ended_tick", "line"], "properties": {
  "task": {"type": "string"}, "version": {"type": "integer"}, "ends": {"$ref": "#/components/schemas/TaskEnd"}, "goal": {"type": "number"}, "repetitions": {"type": "integer"},
  "rest_s": {"type": "number"}, "repetition": {"type": "integer", "description": "The latest one that was begun; 0 = none yet"},
  "begun_tick": {"type": ["integer", "null"], "description": "Step of its first movement"}, "reached": {"type": "boolean", "description": "Its end was reached"},
  "ended_tick": {"type": ["integer", "null"], "description": "Step in which its motion ended: the rest is counted from here"},
  "line": {"$ref": "#/components/schemas/LineOrNull"}}, "additionalProperties": false},
"LineOrNull": {"type": ["string", "null"], "description": "Name of the own line; null: none"},
"TaskRecord": {"type": "object", "description": "The task that a session is a repetition of", "required": ["task", "version", "ends", "goal", "edge_m", "repetition", "repetitions", "rest_s"],
  "properties": {"task": {"type": "string"}, "version": {"type": "integer"}, "ends": {"$ref": "#/components/schemas/TaskEnd"}, "goal": {"type": "number"}, "edge_m": {"type": "number"},
  "repetition": {"type": "integer"}, "repetitions": {"type": "integer"}, "rest_s": {"type": "number"},
  "line": {"type": "string", "description": "Name of the own line, as it was then; left out: none"}}, "additionalProperties": false},
"Walk": {"type": "object", "required": ["exercise", "begun", "task", "tick", "motion_s", "mark", "step_m", "x_m", "y_m"], "properties": {
  "exercise": {"$ref": "#/components/schemas/Exercise", "description": "Chosen for the next walk"},
  "begun": {"anyOf": [{"$ref": "#/components/schemas/Exercise"}, {"$ref": "#/components/schemas/GuidedPath"}, {"type": "null"}],
    "description": "What the present or the latest motion began with; null = not known to this server"},
  "task": {"anyOf": [{"$ref": "#/components/schemas/TaskState"}, {"type": "null"}], "description": "Chosen for the next walks; null = none"},
  "tick": {"type": ["integer", "null"], "description": "Newest step in what follows"},
  "motion_s": {"type": ["number", "null"], "description": "Time in motion since the start mark; null = the mark is older than this server"},
  "mark": {"anyOf": [{"$ref": "#/components/schemas/Pose"}, {"type": "null"}], "description": "Pose at the start mark"},
  "step_m": {"type": "number", "description": "A point of the path each so many metres"},
  "x_m": {"type": "array", "maxItems": 2048, "items": {"type": "number"}}, "y_m": {"type": "array", "maxItems": 2048, "items": {"type": "number"}}},
  "additionalProperties": false},
"ModeState": {"type": "object", "required": ["mode", "moving", "standing_still", "blocked", "stop_cause"], "properties": {"mode": {"type": "string"}, "moving": {"type": "boolean"},
  "standing_still": {"type": "boolean"}, "blocked": {"type": "array", "items": {"type": "string"}}, "stop_cause": {"type": ["array", "null"], "items": {"type": "string"}, "description": "The fault that came first of the stop the hoist is in; null in every other mode"}},
  "additionalProperties": false},
"CalibrationItem": {"type": "object", "required": ["name", "role", "entered", "empty_harness", "title", "action", "done_utc_s"], "properties": {"name": {"$ref": "#/components/schemas/CalibrationStep"},
  "role": {"enum": ["viewer", "therapist", "engineer"]}, "entered": {"anyOf": [{"type": "object", "required": ["unit", "least", "most"], "properties": {"unit": {"enum": ["m", "rad"]},
    "least": {"type": "number"}, "most": {"type": "number"}}, "additionalProperties": false}, {"type": "null"}], "description": "What the operator measures; the sign is the direction"},
  "empty_harness": {"type": "boolean", "description": "The step begins only with harness_empty: true"},
  "title": {"$ref": "#/components/schemas/Words"}, "action": {"$ref": "#/components/schemas/Words"}, "done_utc_s": {"type": ["number", "null"], "description": "null = never"}},
  "additionalProperties": false},
"CalibrationState": {"type": "object", "required": ["step", "phase", "done_percent", "value", "reason", "result"], "properties": {"step": {"$ref": "#/components/schemas/CalibrationStep"},
  "phase": {"enum": ["none", "resting", "measuring", "operator", "result", "refused"]}, "done_percent": {"type": "integer"}, "value": {"type": "number"},
  "reason": {"type": ["string", "null"]}, "result": {"type": "array", "items": {"type": "object", "required": ["name", "value", "before"], "properties": {"name": {"$ref": "#/components/schemas/ParamName"},
    "value": {"type": "number"}, "before": {"type": "number"}}, "additionalProperties": false}}}, "additionalProperties": false},
"Calibration": {"type": "object", "required": ["valid", "under_way", "items", "reasons"], "properties": {"valid": {"type": ["boolean", "null"],
    "description": "Whether a patient may walk; a simulated hoist needs no calibration; null = the core is not connected"},
  "under_way": {"anyOf": [{"$ref": "#/components/schemas/CalibrationState"}, {"type": "null"}]},
  "items": {"type": "array", "items": {"$ref": "#/components/schemas/CalibrationItem"}},
  "reasons": {"type": "array", "items": {"type": "object", "required": ["name", "text"], "properties": {"name": {"type": "string"}, "text": {"$ref": "#/components/schemas/Words"}},
    "additionalProperties": false}}}, "additionalProperties": false},
"CalibrationRequest": {"type": "object", "required": ["step"], "properties": {
  "harness_empty": {"type": "boolean", "description": "True: the operator confirms that nobody is strapped in; steps with empty_harness need it"}, "step": {"$ref": "#/components/schemas/CalibrationStep"}}, "additionalProperties": false},
"CalibrationMeasure": {"type": "object", "required": ["figure"], "properties": {"figure": {"type": "number", "minimum": -1000, "maximum": 1000,
    "description": "In the unit of the step; the sign is the direction; of a square: its side"},
  "x_m": {"type": "number", "minimum": -1000, "maximum": 1000, "description": "Of a square: how far ahead of the shown place it truly ended"},
  "y_m": {"type": "number", "minimum": -1000, "maximum": 1000}, "turning": {"enum": ["left", "right"]}}, "additionalProperties": false},
"ModeRequest": {"type": "object", "required": ["mode"], "properties": {"mode": {"enum": ["user", "remote", "guided", "standby"]}, "exercise": {"$ref": "#/components/schemas/ExerciseOrNull"},
  "path": {"$ref": "#/components/schemas/GuidedPathOrNull"}, "echo": {"$ref": "#/components/schemas/Echo"},
  "start_again": {"type": "boolean", "description": "True sets a new start mark. Otherwise the same exercise goes on from where the hoist is; another one begins at its start"}},
  "additionalProperties": false},
"LeaseRequest": {"type": "object", "properties": {"take_over": {"type": "boolean", "description": "Also when somebody else is in control; only while the hoist stands still"}},
  "additionalProperties": false, "description": "The body may be left out."},
"Lease": {"type": "object", "required": ["holder", "epoch", "actor", "asking"], "properties": {"holder": {"type": "integer", "description": "Number of the client in control; 0 = nobody"},
  "epoch": {"type": "integer", "description": "Rises with each change of holder"}, "actor": {"$ref": "#/components/schemas/ActorOrNull"},
  "asking": {"type": "array", "maxItems": 8, "items": {"$ref": "#/components/schemas/LeaseAsk"}, "description": "Those who ask the holder for control, oldest first"},
  "expires_in_s": {"type": ["number", "null"], "description": "Only in GET /api/v1/lease: when control taken over REST ends without use; null = nobody has it, or a WebSocket, whose end ends it"}},
  "additionalProperties": false},
"LeaseAsk": {"type": "object", "required": ["client", "actor"], "properties": {"client": {"type": "integer"}, "actor": {"$ref": "#/components/schemas/ActorOrNull"}}, "additionalProperties": false},
"LeaseAskRequest": {"type": "object", "properties": {"withdraw": {"type": "boolean", "description": "True: control is asked for no longer"}}, "additionalProperties": false},
"SetRequest": {"type": "object", "required": ["values"], "properties": {"values": {"$ref": "#/components/schemas/ParameterNumbers"}, "version": {"$ref": "#/components/schemas/LookedAt"},
  "revert_after_s": {"$ref": "#/components/schemas/TrialTime"}}, "additionalProperties": false},
"PresetRequest": {"type": "object", "required": ["name"], "properties": {"name": {"type": "string", "maxLength": 64, "description": "Name of the preset"},
  "version": {"$ref": "#/components/schemas/LookedAt"}}, "additionalProperties": false},
"ChooseRequest": {"type": "object", "required": ["exercise"], "properties": {"exercise": {"$ref": "#/components/schemas/Exercise",
  "description": "What is walked next unless the start says otherwise"}}, "additionalProperties": false},
"DriveRequest": {"type": "object", "required": ["sequence", "echo", "speed", "yaw", "held"], "properties": {
  "sequence": {"type": "number", "description": "Rises with every message of one connection"}, "echo": {"type": "number", "description": "time_ns of the newest record seen"},
  "speed": {"type": "number", "minimum": -1, "maximum": 1, "description": "Share of the driving limit, forward positive"},
  "yaw": {"type": "number", "minimum": -1, "maximum": 1, "description": "Share of the turning limit, left positive"}, "held": {"type": "boolean", "description": "Hold-to-run is held"}},
  "additionalProperties": false},
"StreamRequest": {"type": "object", "minProperties": 1, "properties": {"every_tick": {"type": "boolean", "description": "A message for each step; only for the client in control"},
  "topics": {"type": "array", "minItems": 1, "maxItems": 16, "items": {"$ref": "#/components/schemas/TopicName"},
   "description": "Blocks of live values; left out: state, motion, pose, posture, intent"},
  "rate_hz": {"type": "integer", "minimum": 1, "maximum": 100, "enum": [], "description": "Samples per second; left out: 100. A change of state is sent at once at any rate"},
  "last_tick": {"type": "integer", "minimum": 0, "maximum": 9007199254740991, "description": "Newest step that the client has: later ones come first, or are named as missing (gap)"},
  "run": {"type": "string", "maxLength": 32, "description": "Run of the core that last_tick is of, as in the message core"}}, "additionalProperties": false},
"PingRequest": {"type": "object", "required": ["t"], "properties": {"t": {"type": "number", "description": "Comes back in the pong"}}, "additionalProperties": false},
"HandOverRequest": {"type": "object", "minProperties": 1, "maxProperties": 1, "properties": {"client": {"type": "integer", "minimum": 1, "maximum": 4294967295,
  "description": "Number of the client, as in asking"}, "user": {"type": "string", "minLength": 1, "maxLength": 64, "description": "Account: the client of this person that asks, else the one that came last"}},
  "additionalProperties": false},
"LeaseResult": {"type": "object", "required": ["epoch", "holder"], "properties": {"epoch": {"type": "integer"}, "holder": {"type": "integer"}}, "additionalProperties": false},
"Pose": {"type": "object", "required": ["x_m", "y_m", "psi_rad"], "properties": {"x_m": {"type": "number", "minimum": -1000, "maximum": 1000},
  "y_m": {"type": "number", "minimum": -1000, "maximum": 1000}, "psi_rad": {"type": "number", "minimum": -1000, "maximum": 1000}}, "additionalProperties": false},
"Session": {"type": "object", "required": ["id", "started_utc_ms", "ended_utc_ms", "duration_s", "samples", "gaps", "recording", "close_reason", "simulated", "standby", "subject", "study", "visit", "note", "exercise", "task",
  "software_version", "core_version", "layout_hash", "stored_bytes", "etag"], "properties": {"id": {"type": "integer"}, "started_utc_ms": {"type": "integer"}, "ended_utc_ms": {"type": ["integer", "null"]},
  "duration_s": {"type": "number"}, "samples": {"type": "integer"}, "gaps": {"type": "integer"}, "recording": {"type": "boolean"}, "close_reason": {"type": "string"},
  "simulated": {"type": "boolean"}, "standby": {"type": "boolean", "description": "true: recorded in standby with a patient chosen; no walk"},
  "study": {"anyOf": [{"$ref": "#/components/schemas/StudyRun"}, {"type": "null"}], "description": "null: not of a virtual subject"},
  "subject": {"type": ["string", "null"]}, "note": {"type": "string"}, "exercise": {"$ref": "#/components/schemas/ExerciseOrNull"},
  "task": {"anyOf": [{"$ref": "#/components/schemas/TaskRecord"}, {"type": "null"}], "description": "null: no repetition of a task"},
  "visit": {"anyOf": [{"$ref": "#/components/schemas/Visit"}, {"type": "null"}], "description": "null: no patient code is given"},
  "software_version": {"type": "string", "description": "Of the program that recorded: version and commit"},
  "core_version": {"type": ["string", "null"], "description": "Of hoist-control; null = not recorded"}, "layout_hash": {"type": "string"}, "stored_bytes": {"type": "integer"},
  "etag": {"$ref": "#/components/schemas/EditTag"}, "nodes": {"type": "array", "description": "Not in lists. Empty = not recorded", "items": {"$ref": "#/components/schemas/NodeProgram"}}}, "additionalProperties": false},
"NodeProgram": {"type": "object", "description": "What a node had said of its program when the session began; null = not read",
  "required": ["name", "product", "revision", "version", "crc", "simulated"], "properties": {"name": {"type": "string"}, "product": {"type": ["string", "null"]},
  "revision": {"type": ["string", "null"]}, "version": {"type": ["string", "null"]}, "crc": {"type": ["string", "null"]}, "simulated": {"type": ["boolean", "null"]}},
  "additionalProperties": false},
"SessionList": {"type": "object", "required": ["items", "next", "total"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Session"}},
  "next": {"type": ["string", "null"]}, "total": {"type": "integer"}}, "additionalProperties": false},
"Visit": {"type": "object", "description": "One patient on one day", "required": ["id", "patient", "day"], "properties": {"id": {"type": "integer"},
  "patient": {"type": "integer"}, "day": {"type": "string", "description": "YYYY-MM-DD where the recording computer stands"}}, "additionalProperties": false},
"VisitRow": {"type": "object", "description": "One patient on one day", "required": ["id", "patient", "code", "day", "note", "sessions", "standby", "etag"], "properties": {
  "id": {"type": "integer"}, "patient": {"type": "integer"}, "code": {"type": "string"}, "day": {"type": "string"}, "note": {"type": "string"},
  "sessions": {"type": "array", "description": "The walks, in the order of recording", "items": {"type": "integer"}},
  "standby": {"type": "array", "description": "What was recorded in standby before and after them", "items": {"type": "integer"}}, "etag": {"$ref": "#/components/schemas/EditTag"}},
  "additionalProperties": false},
"VisitList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/VisitRow"}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"VisitPatch": {"type": "object", "required": ["note"], "properties": {"note": {"$ref": "#/components/schemas/NoteText"}}, "additionalProperties": false},
"EditTag": {"type": "string", "description": "Of what people may change in this row. Send it in quotes as If-Match with a change; the header ETag has it in quotes"},
"Patient": {"type": "object", "required": ["id", "code", "archived", "has_identity", "visits", "sessions", "first_day", "last_day", "etag"], "properties": {
  "id": {"type": "integer"}, "code": {"type": "string", "description": "Pseudonym"}, "archived": {"type": "boolean"}, "has_identity": {"type": "boolean"},
  "visits": {"type": "integer"}, "sessions": {"type": "integer"}, "first_day": {"type": ["string", "null"]}, "last_day": {"type": ["string", "null"]},
  "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"PatientList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Patient"}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"PatientRequest": {"type": "object", "required": ["code"], "properties": {"code": {"$ref": "#/components/schemas/SubjectCode"}}, "additionalProperties": false},
"PatientPatch": {"type": "object", "properties": {"code": {"$ref": "#/components/schemas/SubjectCode"}, "archived": {"type": "boolean"}},
  "additionalProperties": false},
"Identity": {"type": "object", "required": ["state", "identity", "etag"], "properties": {"state": {"enum": ["none", "readable", "key_missing", "key_foreign", "damaged"],
  "description": "key_missing, key_foreign: the key file beside the database is not there, or of another hoist"},
  "identity": {"anyOf": [{"$ref": "#/components/schemas/Person"}, {"type": "null"}]}, "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"Person": {"type": "object", "required": ["name", "birth_date", "note"], "properties": {"name": {"type": "string"}, "birth_date": {"type": ["string", "null"]},
  "note": {"type": "string"}}, "additionalProperties": false},
"IdentityRequest": {"type": "object", "required": ["name"], "properties": {"name": {"type": "string", "maxLength": 200, "description": "One line, at most 200 bytes of UTF-8"},
  "birth_date": {"type": ["string", "null"], "maxLength": 10, "description": "YYYY-MM-DD"}, "note": {"type": "string", "maxLength": 1000}}, "additionalProperties": false},
"ChosenPatient": {"type": "object", "required": ["id", "code"], "properties": {"id": {"type": ["integer", "null"], "description": "null: nobody is chosen"},
  "code": {"type": ["string", "null"]}}, "additionalProperties": false},
"ChoosePatient": {"type": "object", "required": ["patient"], "properties": {"patient": {"type": ["integer", "null"], "minimum": 1, "description": "Id of a patient; null: nobody"}},
  "additionalProperties": false},
"ProfileSettings": {"type": "object", "description": "Names and values of parameters that a therapist may change", "additionalProperties": {"type": "number"}},
"Profile": {"type": "object", "required": ["id", "patient", "name", "version", "saved_utc_ms", "actor", "settings", "etag"], "properties": {"id": {"type": "integer"},
  "patient": {"type": "integer"}, "name": {"type": "string"}, "version": {"type": "integer", "description": "Counts the savings"}, "saved_utc_ms": {"type": "integer"},
  "actor": {"$ref": "#/components/schemas/ActorOrNull"}, "settings": {"$ref": "#/components/schemas/ProfileSettings"}, "etag": {"$ref": "#/components/schemas/EditTag"}},
  "additionalProperties": false},
"ProfileList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/Profile"}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"ProfileName": {"type": "string", "minLength": 1, "maxLength": 64, "description": "One line, at most 64 bytes of UTF-8"},
"ProfileRequest": {"type": "object", "required": ["name"], "properties": {"name": {"$ref": "#/components/schemas/ProfileName"},
  "settings": {"type": "object", "description": "Left out: what is in force"}}, "additionalProperties": false},
"ProfilePatch": {"type": "object", "properties": {"name": {"$ref": "#/components/schemas/ProfileName"}, "settings": {"type": "object", "description": "Saved as the next version"},
  "from_in_force": {"type": "boolean", "description": "true: what is in force is saved as the next version"}}, "additionalProperties": false},
"ProfileApply": {"type": "object", "required": ["version"], "properties": {"version": {"type": "integer", "minimum": 1, "maximum": 4294967295,
  "description": "Of the parameters that were looked at; refused when others have changed them meanwhile"}}, "additionalProperties": false},
"ProfileDiff": {"type": "object", "required": ["version", "items"], "properties": {"version": {"type": ["integer", "null"], "description": "Of the parameters in force; null: no core is connected"},
  "items": {"type": "array", "items": {"type": "object", "required": ["name", "profile", "in_force", "unusable"], "properties": {"name": {"type": "string"},
  "profile": {"type": "number"}, "in_force": {"type": ["number", "null"]}, "unusable": {"type": "boolean", "description": "No parameter of a therapist in this software, or outside its range"}},
  "additionalProperties": false}}}, "additionalProperties": false},
"NoteText": {"type": "string", "maxLength": 4000, "description": "Plain text, tabs and line ends allowed: at most 4000 bytes of UTF-8."},
"SubjectCode": {"type": "string", "minLength": 1, "maxLength": 64, "description": "A code, never a name"},
"SessionPatch": {"type": "object", "properties": {"note": {"$ref": "#/components/schemas/NoteText"},
  "subject": {"anyOf": [{"$ref": "#/components/schemas/SubjectCode"}, {"type": "null"}]}, "exercise": {"$ref": "#/components/schemas/ExerciseOrNull"}},
  "additionalProperties": false},
"Samples": {"type": "object", "required": ["from_s", "to_s", "gap_before", "columns"], "properties": {"from_s": {"type": "array", "items": {"type": "number"}},
  "to_s": {"type": "array", "items": {"type": "number"}}, "gap_before": {"type": "array", "items": {"type": "integer"}}, "columns": {"type": "array", "items": {"type": "object",
  "required": ["name", "unit", "min", "max"], "properties": {"name": {"type": "string"}, "unit": {"type": "string"}, "min": {"type": "array", "items": {"type": "number"}},
  "max": {"type": "array", "items": {"type": "number"}}}, "additionalProperties": false}}}, "additionalProperties": false},
"Actor": {"type": "object", "description": "Who asked", "required": ["user", "role", "origin", "client"], "properties": {
  "user": {"type": "string", "description": "The account; local for whoever uses this computer itself"}, "role": {"type": "string"},
  "name": {"type": "string", "description": "As screens show it; only of an account, and not in recordings"},
  "origin": {"type": "string", "description": "The protocol: rest, hoist.v1, foxglove or rosbridge; rehearsal: the server itself, for a rehearsal"},
  "client": {"type": "string", "description": "The sign-in: script, or device- and eight digits"}}, "additionalProperties": false},
"ActorOrNull": {"description": "null: not known, or the core by itself", "anyOf": [{"$ref": "#/components/schemas/Actor"}, {"type": "null"}]},
"EventRow": {"type": "object", "required": ["number", "time_s", "tick", "kind", "name", "code", "item", "bits", "value", "before", "actor"], "properties": {
  "number": {"type": "integer", "description": "Within its session"}, "time_s": {"type": "number", "description": "Since the session's start"}, "tick": {"type": "integer"},
  "kind": {"type": "string"}, "name": {"type": "string"}, "code": {"type": "integer"}, "item": {"type": "integer"}, "bits": {"type": "integer"}, "value": {"type": "number"},
  "before": {"type": "number"}, "actor": {"$ref": "#/components/schemas/ActorOrNull"}}, "additionalProperties": false},
"EventList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/EventRow"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"GapRow": {"type": "object", "required": ["number", "stream", "from_tick", "to_tick", "reason"], "properties": {"number": {"type": "integer", "description": "Within its session"},
  "stream": {"type": "string", "description": "ticks, events or bus"}, "from_tick": {"type": "integer"}, "to_tick": {"type": "integer"},
  "reason": {"type": "string", "description": "See the table of reasons in db/README.md"}}, "additionalProperties": false},
"GapList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/GapRow"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"Metrics": {"type": "object", "description": "The figures of db/metrics/metric_list.hpp", "required": ["session", "track", "exercise", "reason_if_none", "reason_code", "computed"],
  "properties": {"session": {"type": "integer"}, "track": {"enum": ["fused", "encoders"], "description": "Which track was compared: with slip repaired, or the encoders' own"},
  "exercise": {"$ref": "#/components/schemas/ExerciseOrNull"}, "reason_if_none": {"type": ["string", "null"], "description": "Why there is no C, J_N, or one of them; of the other figures: computed"},
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoFigure"}, {"type": "null"}]},
  "computed": {"type": "object", "description": "Of each figure", "required": [], "properties": {}, "additionalProperties": false}}, "additionalProperties": false},
"ComputedFrom": {"type": "object", "required": ["version", "inputs", "hash", "reason_code"], "properties": {"version": {"type": "integer", "description": "Of the figure's definition"},
  "inputs": {"type": "array", "items": {"type": "string"}, "description": "Recorded columns, gaps, exercise"},
  "hash": {"type": "string", "description": "Of the values of these inputs: FNV-1a, 16 hexadecimal digits. The same hash and version, the same figure"},
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoFigure"}, {"type": "null"}], "description": "Why the figure is not valid, where it is null"}}, "additionalProperties": false},
"TuningAdvice": {"type": "object", "description": "Advice only: a person decides and sets a value", "required": ["session", "standing_s", "walking_s", "items"], "properties": {
  "session": {"type": "integer"}, "standing_s": {"type": "number", "description": "Standing that it is drawn from, with the patient's standby just before"},
  "walking_s": {"type": "number", "description": "Walking led by the patient"}, "items": {"type": "array", "items": {"$ref": "#/components/schemas/TuningSuggestion"}}}, "additionalProperties": false},
"TuningSuggestion": {"type": "object", "required": ["name", "reason_code", "reason", "now", "suggested", "measured", "measured_unit", "measures", "formula", "effect", "effect_now", "effect_then"],
  "properties": {"name": {"type": "string", "description": "Of the parameter"}, "reason_code": {"type": ["string", "null"], "description": "Why there is no suggestion; its numbers are null then"},
  "reason": {"anyOf": [{"$ref": "#/components/schemas/Words"}, {"type": "null"}]}, "now": {"type": ["number", "null"], "description": "In force when the session began"},
  "suggested": {"type": ["number", "null"], "description": "Inside the parameter's range; the same as now: it may stay"}, "measured": {"type": ["number", "null"]},
  "measured_unit": {"type": "string", "description": "Of measured and both effects; empty: a share"}, "measures": {"$ref": "#/components/schemas/Words"}, "formula": {"type": "string"},
  "effect": {"$ref": "#/components/schemas/Words"}, "effect_now": {"type": ["number", "null"]}, "effect_then": {"type": ["number", "null"], "description": "To be expected"}},
  "additionalProperties": false},
"MarkerRow": {"type": "object", "required": ["session", "number", "tick", "utc_ms", "time_s", "kind", "text", "actor", "rehearsal", "etag"], "properties": {"session": {"type": "integer"},
  "number": {"type": "integer", "description": "Within its session"}, "tick": {"type": "integer"}, "utc_ms": {"type": "integer"}, "time_s": {"type": "number", "description": "Since the session's start"},
  "kind": {"$ref": "#/components/schemas/MarkerKind"}, "text": {"type": "string"}, "actor": {"$ref": "#/components/schemas/ActorOrNull"},
  "rehearsal": {"anyOf": [{"$ref": "#/components/schemas/RehearsalResult"}, {"type": "null"}], "description": "The result that the text tells, of a rehearsal on a simulated hoist"}, "etag": {"$ref": "#/components/schemas/EditTag"}},
  "additionalProperties": false},
"MarkerList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/MarkerRow"}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"ParameterHistory": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/ParameterChange"}},
  "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"ParameterChange": {"type": "object", "required": ["id", "utc_ms", "session", "name", "value", "before", "how", "source", "actor"], "properties": {"id": {"type": "integer"},
  "utc_ms": {"type": "integer"}, "session": {"type": ["integer", "null"], "description": "That was being recorded; null: none"}, "name": {"type": "string", "description": "As it was then"},
  "value": {"type": "number"}, "before": {"type": "number"}, "how": {"$ref": "#/components/schemas/ChangeHow"},
  "source": {"type": ["string", "null"], "description": "Name of the preset or profile"}, "actor": {"$ref": "#/components/schemas/ActorOrNull"}}, "additionalProperties": false},
"ParameterDiff": {"type": "object", "required": ["from_utc_ms", "to_utc_ms", "items"], "properties": {"from_utc_ms": {"type": "integer"}, "to_utc_ms": {"type": "integer"},
  "items": {"type": "array", "items": {"type": "object", "required": ["name", "from", "to"], "properties": {"name": {"type": "string"}, "from": {"type": "number"}, "to": {"type": "number"}},
  "additionalProperties": false}}}, "additionalProperties": false},
"AlarmList": {"type": "object", "required": ["items", "next"], "properties": {"items": {"type": "array", "items": {"type": "object",
  "required": ["session", "utc_ms", "time_s", "fault", "lasted_s", "simulated", "subject"], "properties": {"session": {"type": "integer"}, "utc_ms": {"type": "integer"},
  "time_s": {"type": "number", "description": "Since the session's start"}, "fault": {"type": "string", "description": "As it was called then; words in /api/v1/faults"},
  "lasted_s": {"type": ["number", "null"], "description": "null: not over before the session's end"}, "simulated": {"type": "boolean"}, "subject": {"type": ["string", "null"]}},
  "additionalProperties": false}}, "next": {"type": ["string", "null"]}}, "additionalProperties": false},
"DeviceSettings": {"type": "object", "required": ["hoist_id", "device_name", "computer_name", "language", "etag"], "properties": {"hoist_id": {"type": "string", "description": "UUID: made once, at random; cannot be changed"},
  "device_name": {"type": "string", "description": "Empty: the computer's name"},
  "computer_name": {"type": "string"}, "language": {"$ref": "#/components/schemas/LanguageOrNull"}, "etag": {"$ref": "#/components/schemas/EditTag"}}, "additionalProperties": false},
"DeviceSettingsPatch": {"type": "object", "minProperties": 1, "properties": {"device_name": {"type": "string", "maxLength": 64, "description": "One line, at most 64 bytes of UTF-8"},
  "language": {"$ref": "#/components/schemas/LanguageOrNull"}}, "additionalProperties": false},
"Time": {"type": "object", "required": ["utc_ms", "steady_ns", "kept_by", "synchronised", "client_behind_s"], "properties": {"utc_ms": {"type": "integer"}, "steady_ns": {"type": "integer"},
  "kept_by": {"enum": ["operating_system", "engineers"], "description": "Who may set it"},
  "synchronised": {"type": ["boolean", "null"], "description": "Whether the operating system has it from a time server; null: it does not say"},
  "client_behind_s": {"type": ["number", "null"], "description": "How far the client's clock is behind, the way of the request included"}}, "additionalProperties": false},
"TimeRequest": {"type": "object", "required": ["utc_ms"], "properties": {"utc_ms": {"type": "integer", "minimum": 1577836800000, "maximum": 4102444800000}}, "additionalProperties": false},
"Network": {"type": "object", "required": ["computer_name", "port", "interfaces", "tls"], "properties": {"computer_name": {"type": "string"}, "port": {"type": "integer"},
  "interfaces": {"type": "array", "items": {"type": "object", "required": ["name", "up", "loopback", "addresses"], "properties": {"name": {"type": "string"}, "up": {"type": "boolean"},
  "loopback": {"type": "boolean"}, "addresses": {"type": "array", "items": {"type": "string"}}}, "additionalProperties": false}},
  "tls": {"type": "object", "required": ["on", "names", "fingerprint", "trust_page"], "properties": {"on": {"type": "boolean"},
  "names": {"type": "array", "items": {"type": "string"}, "description": "Under which the hoist may be called"},
  "fingerprint": {"type": ["string", "null"], "description": "Of the hoist's own authority, SHA-256; null: it has none"},
  "trust_page": {"type": ["string", "null"], "description": "Path of the page that explains how a device comes to trust it"}}, "additionalProperties": false}}, "additionalProperties": false},
"TrendItem": {"type": "object", "required": ["session", "visit", "day", "started_utc_ms", "exercise", "task", "ends", "line", "figures", "reasons", "reason_code"], "properties": {"session": {"type": "integer"}, "visit": {"type": "integer"},
  "day": {"type": "string"}, "started_utc_ms": {"type": "integer"}, "exercise": {"$ref": "#/components/schemas/ExerciseOrNull"},
  "task": {"type": ["string", "null"], "description": "Name of the task that it is a repetition of; walks are compared within one exercise, task and goal"},
  "ends": {"$ref": "#/components/schemas/TaskGoalOrNull"},
  "line": {"type": ["string", "null"], "description": "Name of an own line when it was walked"},
  "figures": {"anyOf": [{"$ref": "#/components/schemas/TrendFigures"}, {"type": "null"}], "description": "null: the recording cannot be read"},
  "reasons": {"type": "object", "description": "Of each figure that is null: why", "additionalProperties": {"$ref": "#/components/schemas/NoFigure"}},
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoFigure"}, {"type": "null"}], "description": "Why there is no C, J_N, or one of them"}}, "additionalProperties": false},
"Trend": {"type": "object", "required": ["items", "next", "firsts", "simulated_left_out", "changes"], "properties": {"items": {"type": "array", "items": {"$ref": "#/components/schemas/TrendItem"}},
  "next": {"type": ["string", "null"]}, "firsts": {"type": "array", "description": "The first walk of each exercise, task and goal among the items, where it is older than this page; newest first", "items": {"$ref": "#/components/schemas/TrendItem"}},
  "simulated_left_out": {"type": "integer", "description": "Recordings of this patient with a simulated hoist"},
  "changes": {"type": "array", "description": "Newest value of this page against the first one of all, of each figure, within one exercise, task and goal", "items": {"$ref": "#/components/schemas/FigureChange"}}},
  "additionalProperties": false},
"TaskGoalOrNull": {"anyOf": [{"type": "null"}, {"type": "object", "required": ["by", "goal", "edge_m"], "properties": {"by": {"$ref": "#/components/schemas/TaskEnd"},
  "goal": {"type": "number", "description": "Times along the line, seconds, radians, metres"}, "edge_m": {"type": "number"}}, "additionalProperties": false}],
  "description": "What ended the task when it was walked; null: no task"},
"FigureChange": {"type": "object", "required": ["exercise", "task", "ends", "figure", "first_session", "last_session", "first", "last",
   "minimal_detectable_change", "source", "whom", "repeats", "reason_code", "retention", "learning"],
  "properties": {"exercise": {"$ref": "#/components/schemas/ExerciseOrNull"}, "task": {"type": ["string", "null"]}, "ends": {"$ref": "#/components/schemas/TaskGoalOrNull"}, "figure": {"type": "string"},
  "first_session": {"type": "integer"}, "last_session": {"type": "integer"}, "first": {"type": "number"}, "last": {"type": "number"},
  "minimal_detectable_change": {"type": ["number", "null"], "description": "95 %, in the figure's unit: the published one or that of the patient's own repeats, the larger one; null: not known"},
  "source": {"type": ["string", "null"], "description": "Where it is published; null: the patient's own repeats, or not known"},
  "whom": {"anyOf": [{"type": "object", "required": ["en", "de"], "properties": {"en": {"type": "string"}, "de": {"type": "string"}}, "additionalProperties": false}, {"type": "null"}],
   "description": "Whom and what it is published of"},
  "repeats": {"type": "integer", "description": "Degrees of freedom of the patient's own repeats within visits; 10 are needed"},
  "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoChange"}, {"type": "null"}],
   "description": "Why no change can be told; null: last differs from first by more than the minimal detectable change"},
  "retention": {"anyOf": [{"type": "object", "required": ["before_session", "after_session", "before", "after", "reason_code"], "properties": {
   "before_session": {"type": "integer"}, "after_session": {"type": "integer"}, "before": {"type": "number"}, "after": {"type": "number"},
   "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoChange"}, {"type": "null"}],
    "description": "null: they differ by more than the minimal detectable change"}}, "additionalProperties": false},
   {"type": "null"}],
   "description": "What was kept: first value of the newest visit (after) against the last one of the visit before; null: only one visit"},
  "learning": {"type": "object", "description": "Within visits, from walk to walk",
   "required": ["walks", "visits", "slope", "reason_code"], "properties": {
   "walks": {"type": "integer", "description": "Of visits with at least two walks"},
   "visits": {"type": "integer", "description": "With at least two walks"},
   "slope": {"anyOf": [{"type": "object", "required": ["middle", "low", "high"], "properties": {"middle": {"type": "number"},
     "low": {"type": "number"}, "high": {"type": "number"}}, "additionalProperties": false},
    {"type": "null"}], "description": "Median of the slopes between two walks of a visit, per walk, and its 95 % interval; null: too few walks"},
   "reason_code": {"anyOf": [{"$ref": "#/components/schemas/NoChange"}, {"type": "null"}],
    "description": "Why no learning can be told; null: the interval leaves out 0"}}, "additionalProperties": false}},
  "additionalProperties": false},
"TrendFigures": {"type": "object", "description": "The figures of db/metrics/metric_list.hpp; null: not defined for this session", "required": [], "properties": {}, "additionalProperties": false},
"MarkerRequest": {"type": "object", "required": ["text"], "properties": {"text": {"type": "string", "maxLength": 500}, "kind": {"$ref": "#/components/schemas/MarkerKind"}},
  "additionalProperties": false},
"MarkerPatch": {"type": "object", "minProperties": 1, "properties": {"text": {"type": "string", "maxLength": 500}, "kind": {"$ref": "#/components/schemas/MarkerKind"},
  "time_s": {"type": "number", "minimum": 0, "description": "Since the session's start, within its samples"}}, "additionalProperties": false},
"FirmwareUpdate": {"type": "object", "required": ["node", "version", "phase", "result", "bytes_sent", "bytes_total", "seconds_left", "text"], "properties": {
  "node": {"type": "string"}, "version": {"type": "string"}, "phase": {"enum": ["listening", "asking_drives", "asking_node", "entering_loader", "sending", "checking", "starting",
  "done", "failed"]}, "result": {"enum": ["running", "done", "unchanged", "failed", "interrupted"]}, "bytes_sent": {"type": "integer"}, "bytes_total": {"type": "integer"},
  "seconds_left": {"type": ["number", "null"], "description": "Of the sending"}, "text": {"type": "string"}}, "additionalProperties": false},
"Firmware": {"type": "object", "required": ["nodes", "update"], "properties": {"nodes": {"type": "array", "items": {"type": "object",
  "required": ["name", "title", "in_loader", "version", "crc"], "properties": {"name": {"type": "string"}, "title": {"type": "string"},
  "in_loader": {"type": ["boolean", "null"], "description": "null = not heard since this server or the node started"}, "version": {"type": ["string", "null"]},
  "crc": {"type": ["string", "null"], "description": "8 hexadecimal digits"}}, "additionalProperties": false}},
  "update": {"anyOf": [{"$ref": "#/components/schemas/FirmwareUpdate"}, {"type": "null"}]}}, "additionalProperties": false},
"Recording": {"type": "object", "required": ["state", "session", "standby", "started_utc_ms", "samples", "durable_tick", "detail", "reason_code"], "properties": {"state": {"enum": ["idle", "recording", "failed"]},
  "session": {"type": ["integer", "null"]}, "standby": {"type": "boolean", "description": "true: no walk, but the time in standby with a patient chosen"},
  "started_utc_ms": {"type": ["integer", "null"]}, "samples": {"type": "integer"}, "durable_tick": {"type": ["integer", "null"]},
  "detail": {"type": "string"}, "reason_code": {"anyOf": [{"$ref": "#/components/schemas/ReasonCode"}, {"type": "null"}], "description": "Why it failed, for programs"}}, "additionalProperties": false},
"RecordingRequest": {"type": "object", "required": ["action"], "properties": {"action": {"enum": ["start", "stop"]},
  "subject": {"$ref": "#/components/schemas/SubjectCode"}, "note": {"$ref": "#/components/schemas/NoteText"}}, "additionalProperties": false}
})json";

// The names of a table's rows, as the choices of a text.
json names_of(const auto& rows) {
  json names = json::array();
  for (const auto& row : rows) names.push_back(row.name);
  return {{"type", "string"}, {"enum", std::move(names)}};
}

// The figures of a session, and of each what it was computed from.
void add_figures(json& metrics) {
  json& computed = metrics["properties"]["computed"];
  for (const db::MetricInfo& row : db::kMetrics) {
    const std::string key{row.key};
    const json type = row.nullable ? json::array({"number", "null"}) : json("number");
    metrics["properties"][key] = {{"type", type}, {"description", row.doc}};
    metrics["required"].push_back(key);
    computed["properties"][key] = {{"$ref", "#/components/schemas/ComputedFrom"}};
    computed["required"].push_back(key);
  }
}

void add_trend_figures(json& figures) {
  for (const db::MetricInfo& row : db::kMetrics) {
    const std::string key{row.key};
    figures["properties"][key] = {{"type", row.nullable ? json::array({"number", "null"}) : json("number")}, {"description", row.doc}};
    figures["required"].push_back(key);
  }
}

// One kind of exercise, from its rows; `driven`: as the hoist drives it by itself.
json exercise_kind(const contract::ExerciseInfo& info, bool driven) {
  json kind{
      {"type", "object"}, {"required", {"shape"}}, {"properties", {{"shape", {{"const", info.name}}}}}, {"additionalProperties", false}};
  json& properties = kind["properties"];
  for (const contract::ExerciseSize& row : contract::kExerciseSizes) {
    if (row.shape != info.shape) continue;
    const double most_m = driven ? row.driven_most_m : contract::kExerciseMost_m * (row.share > 0 ? row.share : 1);
    const double least_m = !row.required ? 0 : driven ? row.driven_least_m : contract::kExerciseLeast_m;
    properties[std::string{row.name}] = {{"type", row.required ? json("number") : json{"number", "null"}},
                                         {"minimum", least_m},
                                         {"maximum", most_m},
                                         {"description", row.doc}};
    if (row.required) kind["required"].push_back(row.name);
  }
  if (info.shape == contract::ExerciseShape::own) {
    kind["required"] = {"shape", "closed", "x_m", "y_m"};
    properties["closed"] = {{"type", "boolean"}, {"description", "The last point is joined to the first; then at least three"}};
    for (const auto& [name, what] :
         {std::pair{"x_m", "Of the points, in whole centimetres, in the order of walking; neighbours are at least 0.2 m apart"},
          std::pair{"y_m", "As many as x_m"}})
      properties[name] = {{"type", "array"},
                          {"minItems", contract::own_points_least(false)},
                          {"maxItems", contract::kOwnPointsMost},
                          {"items", {{"type", "number"}, {"minimum", -contract::kOwnReach_m}, {"maximum", contract::kOwnReach_m}}},
                          {"description", what}};
  }
  if (info.turned) properties["clockwise"] = {{"type", {"boolean", "null"}}, {"description", "Left and right exchanged"}};
  if (driven) {
    kind["required"].push_back("speed_m_s");
    properties["speed_m_s"] = {
        {"type", "number"}, {"minimum", contract::kGuidedSpeedLeast_m_s}, {"description", "Slower in curves that need it"}};
    properties["laps"] = {{"type", {"integer", "null"}}, {"minimum", 1}, {"maximum", info.closed ? contract::kGuidedLapsMost : 1U}};
  }
  return kind;
}

json all_schemas() {
  json schemas = json::parse(kSchemas);
  add_figures(schemas["Metrics"]);
  add_trend_figures(schemas["TrendFigures"]);
  schemas["SubjectCode"]["description"] = "A code, never a name: " + std::string(db::kCodeRule) +
                                          ". Spaces around it are dropped; capital and small letters do not tell codes apart.";
  schemas["MarkerKind"] = {
      {"type", "string"}, {"enum", db::kMarkerKinds}, {"description", "What kind of moment it marks; note: none of these"}};
  schemas["ChangeHow"] = {{"type", "string"}, {"enum", db::kChangeReasons}};
  schemas["Exercise"] = {{"description", "What is walked; null and free mean the same"}, {"anyOf", json::array()}};
  schemas["GuidedPath"] = {
      {"description",
       "What the hoist drives while the driver holds: the sizes of an exercise, its speed and its laps, held against the limits in force"},
      {"anyOf", json::array()}};
  for (const contract::ExerciseInfo& row : contract::kExercises) {
    schemas["Exercise"]["anyOf"].push_back(exercise_kind(row, false));
    if (contract::drivable(row.shape)) schemas["GuidedPath"]["anyOf"].push_back(exercise_kind(row, true));
  }
  schemas["CalibrationStep"] = names_of(contract::kCalibrationSteps);
  schemas["ParamName"] = names_of(contract::kParams);
  schemas["ReasonCode"] = names_of(kReasons);
  schemas["RehearsalKind"] = names_of(kRehearsals);
  schemas["RehearsalKind"]["description"] = "What happens to staff who rehearse (server/contract/rehearsals.def)";
  schemas["RehearsalCheck"] = names_of(kRehearsalChecks);
  schemas["RehearsalCheck"]["description"] = "What is looked at";
  for (const RehearsalCheckInfo& check : kRehearsalChecks)
    schemas["RehearsalCheck"]["description"] = schemas["RehearsalCheck"]["description"].get<std::string>() +
                                               (check.name == kRehearsalChecks.front().name ? ": " : "; ") + std::string(check.name) +
                                               ": " + std::string(check.doc);
  schemas["TopicName"] = names_of(kTopics);
  schemas["StreamRequest"]["properties"]["rate_hz"]["enum"] = kStreamRates_hz;
  schemas["AuditAction"] = names_of(kAuditKinds);
  schemas["AuditAction"]["description"] = "What was done or tried: an action, or a REST operation";
  schemas["JobKind"] = names_of(kJobKinds);
  schemas["NoFigure"] = {{"type", "string"}, {"enum", json::array()}};
#define HOIST_NO_FIGURE(name, text_en, text_de) schemas["NoFigure"]["enum"].push_back(#name);
#include "db/metrics/no_figure.def"
#undef HOIST_NO_FIGURE
  schemas["NoChange"] = {{"type", "string"}, {"enum", json::array()}};
#define HOIST_NO_CHANGE(name, text_en, text_de) schemas["NoChange"]["enum"].push_back(#name);
#include "db/metrics/no_change.def"
#undef HOIST_NO_CHANGE
  return schemas;
}
}  // namespace

const json& schemas() {
  static const json kAll = all_schemas();
  return kAll;
}

}  // namespace hoist::server
