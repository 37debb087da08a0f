#include <array>

#include "deploy/tools/hoist/command.hpp"

namespace hoist::tool {

int run_firmware(std::span<const std::string_view> arguments);
int run_laws(std::span<const std::string_view> arguments);
int run_sessions(std::span<const std::string_view> arguments);
int run_export(std::span<const std::string_view> arguments);
int run_sql_command(std::span<const std::string_view> arguments);
int run_metrics(std::span<const std::string_view> arguments);
int run_report(std::span<const std::string_view> arguments);
int run_study(std::span<const std::string_view> arguments);
int run_tune_advice(std::span<const std::string_view> arguments);
int run_twin(std::span<const std::string_view> arguments);
int run_verify(std::span<const std::string_view> arguments);
int run_replay(std::span<const std::string_view> arguments);
int run_archive(std::span<const std::string_view> arguments);
int run_backup(std::span<const std::string_view> arguments);
int run_restore(std::span<const std::string_view> arguments);
int run_user(std::span<const std::string_view> arguments);
int run_audit(std::span<const std::string_view> arguments);
int run_bus(std::span<const std::string_view> arguments);

namespace {

constexpr std::array kCommands = {
    Command{"laws", "compute the paper's equations from JSON lines", &run_laws},
    Command{"sessions", "list the sessions of a database", &run_sessions},
    Command{"export", "write recorded sessions in the formats of other programs", &run_export},
    Command{"sql", "ask a file of recordings in SQL, samples included", &run_sql_command},
    Command{"metrics", "the figures of recorded sessions, and whether told ones still hold", &run_metrics},
    Command{"report", "recorded sessions as pages for print: for a patient, for a clinician, several in one table", &run_report},
    Command{"study", "the paper's experiment: virtual subjects or recorded sessions, Tables II and III", &run_study},
    Command{"tune-advice", "settings suggested from how a patient stood and walked", &run_tune_advice},
    Command{"twin", "a patient fitted to a session, and other parameters tried on it", &run_twin},
    Command{"verify", "run a session again and compare every field, bit for bit", &run_verify},
    Command{"replay", "run a session again with other parameters", &run_replay},
    Command{"archive", "an archive of several hoists in PostgreSQL: push, pull, list, verify", &run_archive},
    Command{"backup", "copy a database of recordings into a folder, and check the copy", &run_backup},
    Command{"restore", "put a backup in the place of a database", &run_restore},
    Command{"user", "accounts of the server: list, add, new password", &run_user},
    Command{"audit", "the audit log: verify, list", &run_audit},
    Command{"bus", "look at the CAN bus and its recordings", &run_bus},
    Command{"firmware", "the nodes' programs: pack, list, update", &run_firmware},
};

}  // namespace

std::span<const Command> command_list() { return kCommands; }

}  // namespace hoist::tool
