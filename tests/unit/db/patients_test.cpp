// Patients, their sealed identities and profiles, notes of visits, the log of parameters.
#include <fstream>
#include <iterator>
#include <random>

#include "db/export/session_export.hpp"
#include "db/store/identity_key.hpp"
#include "db/store/parameter_log.hpp"
#include "db/store/patients.hpp"
#include "db/store/profiles.hpp"
#include "db/store/session_reader.hpp"
#include "db/store/sqlite.hpp"
#include "tests/unit/db/db_support.hpp"

namespace hoist::db::test {
namespace {

class Patients : public ::testing::Test {
 protected:
  void SetUp() override { open(); }
  void open() {
    auto opened = Database::open(folder_ / "hoist.db");
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    database_.emplace(std::move(*opened));
  }
  PatientStore store() { return PatientStore(*database_); }
  PatientInfo made(const std::string& code) {
    auto patient = store().create(code);
    EXPECT_TRUE(patient.ok()) << patient.error().message;
    return *patient;
  }
  SessionId record(const std::string& code) {
    auto writer = SessionWriter::create(*database_);
    SessionStart start = start_of_walk();
    start.subject = code;
    const auto id = writer->begin(start);
    EXPECT_TRUE(writer->append_ticks(Walk(1).records(1, 200)).ok());
    EXPECT_TRUE(writer->end(CloseReason::finished, kStartUtc_ns).ok());
    return *id;
  }
  // Where in the folder these bytes are: names of files.
  std::vector<std::string> files_with(const std::string& bytes) {
    std::vector<std::string> found;
    for (const auto& entry : std::filesystem::directory_iterator(folder_.path())) {
      std::ifstream in(entry.path(), std::ios::binary);
      const std::string all{std::istreambuf_iterator<char>(in), {}};
      if (all.find(bytes) != std::string::npos) found.push_back(entry.path().filename());
    }
    return found;
  }

  TemporaryFolder folder_;
  std::optional<Database> database_;
};

const Identity kWho{.name = "Zdenka Marolt-Quux", .birth_date = "1948-02-29", .note = "allergic to Heftpflaster"};

TEST_F(Patients, ThatPeopleMadeStayWithoutASessionAndOthersGoWithTheirLast) {
  const PatientInfo kept = made("P-1");
  EXPECT_EQ(store().create("P-1").error().kind, ErrorKind::taken);
  for (const char* bad : {"", "two\nlines"}) EXPECT_EQ(store().create(bad).error().field, "code") << bad;
  EXPECT_FALSE(kept.first_day);
  const SessionId first = record("P-1"), typed = record("P-2");
  const VisitReader reader(*database_);
  EXPECT_EQ(reader.patients()->items.size(), 2U);
  ASSERT_TRUE(SessionEditor(*database_).remove(first).ok());
  ASSERT_TRUE(SessionEditor(*database_).remove(typed).ok());
  const auto left = reader.patients();
  ASSERT_EQ(left->items.size(), 1U);
  EXPECT_EQ(left->items[0].id, kept.id);
  EXPECT_EQ(left->items[0].sessions, 0U);
  EXPECT_EQ(reader.patients({.code_part = "p-"})->items.size(), 1U);
  EXPECT_EQ(reader.patients({.code_part = "017"})->items.size(), 0U);
}

TEST_F(Patients, AChangeIsMadeForWhatWasSeen) {
  const PatientInfo before = made("P-1");
  made("P-2");
  const auto renamed = store().change(before.id, {.code = "P-3", .archived = {}}, before.tag);
  ASSERT_TRUE(renamed.ok());
  EXPECT_NE(renamed->tag, before.tag);
  EXPECT_EQ(store().change(before.id, {.code = "P-4", .archived = {}}, before.tag).error().kind, ErrorKind::changed);
  EXPECT_EQ(store().change(before.id, {.code = "P-2", .archived = {}}, {}).error().kind, ErrorKind::taken);
  EXPECT_EQ(store().change(99, {.code = "X", .archived = {}}, {}).error().kind, ErrorKind::not_found);
  EXPECT_EQ(store().get(before.id)->code, "P-3") << "what was refused changed nothing";
  EXPECT_TRUE(store().change(before.id, {.code = {}, .archived = true}, {})->archived);
  EXPECT_EQ(store().choose(before.id).error().kind, ErrorKind::wrong_state) << "archived";
  EXPECT_EQ(VisitReader(*database_).patients({.archived = false})->items.size(), 1U);
}

TEST_F(Patients, OneRuleForCodesWhereverTheyAreTyped) {
  EXPECT_EQ(made(" P-017\t").code, "P-017") << "trimmed";
  EXPECT_EQ(made("MÜL_3.b").code, "MÜL_3.b");
  EXPECT_EQ(made(std::string(32, 'x')).code.size(), 32U);
  std::string letters;
  for (int i = 0; i < 32; ++i) letters += "ž";
  EXPECT_EQ(made(letters).code.size(), 64U) << "letters count, not bytes";
  const std::string long_one(33, 'y');
  for (const char* bad : {"", "  ", "Anna Novak", "P/17", "100%", "-1", ".x", "_", "a\x7f", "P\xC5",
                          "\xE2\x82\xAC"
                          "5",
                          "\xC3\x97"
                          "2",
                          "\xCE\xB1", long_one.c_str()}) {
    const auto refused = store().create(bad);
    ASSERT_FALSE(refused.ok()) << bad;
    EXPECT_EQ(refused.error().kind, ErrorKind::bad_value) << bad;
    EXPECT_EQ(refused.error().field, "code") << bad;
    EXPECT_NE(refused.error().message.find("1 to 32 letters, digits"), std::string::npos) << refused.error().message;
  }
  // Capital or small, it is one patient: for those that are made, renamed, recorded and corrected.
  EXPECT_EQ(store().create("p-017").error().kind, ErrorKind::taken);
  EXPECT_EQ(store().create("mül_3.B").error().kind, ErrorKind::taken);
  const PatientInfo other = made("Q-1");
  EXPECT_EQ(store().change(other.id, {.code = "mül_3.b", .archived = {}}, {}).error().kind, ErrorKind::taken);
  EXPECT_EQ(store().change(other.id, {.code = " q-1 ", .archived = {}}, {})->code, "q-1") << "its own";
  EXPECT_EQ(store().change(other.id, {.code = "Q 1", .archived = {}}, {}).error().field, "code");
  const SessionId session = record("p-017");
  EXPECT_EQ(SessionReader(*database_).get(session)->subject, "P-017");
  const auto correct = [&](const char* code) {
    return SessionEditor(*database_).patch(session, {.note = {}, .subject = std::optional<std::string>(code), .exercise_json = {}});
  };
  ASSERT_TRUE(correct(" Mül_3.B ").ok());
  EXPECT_EQ(SessionReader(*database_).get(session)->subject, "MÜL_3.b");
  const Status refused = correct("Anna Novak");
  EXPECT_EQ(refused.error().field, "subject");
  EXPECT_NE(refused.error().message.find("1 to 32 letters, digits"), std::string::npos);
  EXPECT_EQ(SessionReader(*database_).get(session)->subject, "MÜL_3.b");
  // From before the rule: recorded on, kept, corrected to, and told apart where there were two.
  execute(database_->handle(), "INSERT INTO patients (code, registered) VALUES ('Bed 4', 1), ('P-017x', 1), ('p-017X', 1)");
  EXPECT_EQ(SessionReader(*database_).get(record("Bed 4"))->subject, "Bed 4");
  EXPECT_TRUE(correct("bed 4").ok());
  EXPECT_EQ(SessionReader(*database_).get(record("p-017X"))->subject, "p-017X");
  EXPECT_EQ(SessionReader(*database_).get(record("Never Made"))->subject, "Never Made")
      << "a walk is never refused for a code that was chosen";
}

TEST_F(Patients, AVisitsNoteIsWrittenForWhatWasSeen) {
  record("P-1");
  const VisitReader reader(*database_);
  const VisitInfo visit = reader.visits()->items.at(0);
  ASSERT_TRUE(store().note_visit(visit.visit.id, "tired today", visit.tag).ok());
  EXPECT_EQ(store().note_visit(visit.visit.id, "fresh", visit.tag).error().kind, ErrorKind::changed);
  EXPECT_EQ(reader.visit(visit.visit.id)->note, "tired today");
  EXPECT_EQ(reader.visits({.day = visit.visit.day})->items.size(), 1U);
  EXPECT_EQ(reader.visits({.day = "1999-01-01"})->items.size(), 0U);
}

// The plain bytes are in no file of the folder, at no time.
TEST_F(Patients, AnIdentityIsNowhereInPlainBytes) {
  const PatientInfo patient = made("P-1");
  const auto nowhere = [&](const char* when) {
    for (const std::string& part : {kWho.name, *kWho.birth_date, kWho.note})
      EXPECT_EQ(files_with(part), std::vector<std::string>{}) << when;
  };
  ASSERT_EQ(files_with("P-1").size(), 1U) << "the search finds what is there";
  ASSERT_TRUE(store().set_identity(patient.id, kWho, {}).ok());
  nowhere("after sealing");
  const auto told = store().identity(patient.id);
  ASSERT_EQ(told->state, IdentityState::readable);
  EXPECT_EQ(told->identity->name, kWho.name);
  EXPECT_EQ(told->identity->birth_date, kWho.birth_date);
  EXPECT_EQ(told->identity->note, kWho.note);
  nowhere("after reading");
  const auto mode = std::filesystem::status(IdentityKey::beside(folder_ / "hoist.db")).permissions();
  EXPECT_EQ(mode, std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);
  const SessionId session = record("P-1");
  for (const char* format : {"csv", "json", "events"}) {
    ExportOptions options;
    options.format = find_export_format(format).value();
    auto exported = SessionExport::open(*database_, session, options);
    ASSERT_TRUE(exported.ok());
    std::string all, piece;
    for (bool more = true; more;) {
      more = exported->next_chunk(piece).value();
      all += piece;
    }
    EXPECT_NE(all.find("P-1"), std::string::npos);
    EXPECT_EQ(all.find("Marolt"), std::string::npos);
    EXPECT_EQ(all.find(*kWho.birth_date), std::string::npos);
  }

  // The sealed bytes themselves leave file and log with the patient.
  std::string sealed;
  {
    Statement row(database_->handle(), "SELECT sealed FROM patient_identities");
    ASSERT_TRUE(row.step());
    const ByteView bytes = row.blob_at(0);
    sealed.assign(bytes.begin(), bytes.end());
  }
  ASSERT_EQ(files_with(sealed).size(), 1U);
  EXPECT_EQ(store().remove(patient.id, {}).error().kind, ErrorKind::wrong_state) << "it still has sessions";
  ASSERT_TRUE(SessionEditor(*database_).remove(session).ok());
  ASSERT_TRUE(store().remove(patient.id, {}).ok());
  EXPECT_EQ(files_with(sealed), std::vector<std::string>{});
  nowhere("after deletion");
  EXPECT_EQ(store().get(patient.id).error().kind, ErrorKind::not_found);
}

TEST_F(Patients, WithoutTheRightKeyCodesGoOnAndTheIdentitySaysWhy) {
  const std::int64_t id = made("P-1").id, other = made("P-2").id;
  ASSERT_TRUE(store().set_identity(id, kWho, {}).ok());
  const std::filesystem::path key = IdentityKey::beside(folder_ / "hoist.db"), away = folder_ / "away";
  std::filesystem::rename(key, away);
  EXPECT_EQ(store().identity(id)->state, IdentityState::key_missing);
  EXPECT_EQ(store().get(id)->code, "P-1");
  EXPECT_EQ(store().set_identity(other, kWho, {}).error().field, "key") << "a second key would hide that the first is lost";
  EXPECT_FALSE(std::filesystem::exists(key));
  std::ofstream(key) << std::string(32, 'k');
  EXPECT_EQ(store().identity(id)->state, IdentityState::key_foreign);
  EXPECT_EQ(store().set_identity(other, kWho, {}).error().field, "key");
  std::ofstream(key, std::ios::trunc) << "short";
  EXPECT_EQ(store().identity(id)->state, IdentityState::key_missing);
  std::filesystem::rename(away, key);
  EXPECT_EQ(store().identity(id)->state, IdentityState::readable);

  // Sealed bytes of one patient are nothing under another, and one changed bit is seen.
  execute(database_->handle(),
          ("INSERT INTO patient_identities SELECT " + std::to_string(other) + ", key_id, sealed FROM patient_identities").c_str());
  EXPECT_EQ(store().identity(other)->state, IdentityState::damaged);
  const auto stored = [&](std::int64_t patient) {
    Statement row(database_->handle(), "SELECT sealed FROM patient_identities WHERE patient_id = ?1");
    EXPECT_TRUE(row.integer(1, patient).step());
    const ByteView bytes = row.blob_at(0);
    return Bytes(bytes.begin(), bytes.end());
  };
  const Bytes whole = stored(id);
  std::mt19937 random(7);
  for (int i = 0; i < 100; ++i) {
    Bytes flipped = whole;
    flipped[random() % flipped.size()] ^= static_cast<std::uint8_t>(1U << random() % 8U);
    Statement(database_->handle(), "UPDATE patient_identities SET sealed = ?2 WHERE patient_id = ?1").integer(1, id).blob(2, flipped).run();
    ASSERT_EQ(store().identity(id)->state, IdentityState::damaged);
  }
  ASSERT_TRUE(store().clear_identity(id, {}).ok()) << "needs no key";
  EXPECT_EQ(store().identity(id)->state, IdentityState::none);
}

TEST_F(Patients, FieldsOfAnIdentityNameTheirRangeAndNeverWhatWasWritten) {
  const std::int64_t id = made("P-1").id;
  for (const char* day : {"1948-02-30", "1900-02-29", "48-02-01", "1948/02/01", "1948-13-01", "1948-04-31", "-948-01-01"}) {
    const auto refused = store().set_identity(id, {.name = "Anna", .birth_date = day, .note = ""}, {});
    ASSERT_FALSE(refused.ok()) << day;
    EXPECT_EQ(refused.error().field, "birth_date");
    EXPECT_EQ(refused.error().message.find(day), std::string::npos);
  }
  EXPECT_TRUE(store().set_identity(id, {.name = "Anna", .birth_date = "2000-02-29", .note = ""}, {}).ok());
  EXPECT_EQ(store().set_identity(id, {.name = std::string(201, 'n'), .birth_date = {}, .note = ""}, {}).error().field, "name");
  EXPECT_EQ(store().set_identity(id, {.name = "", .birth_date = {}, .note = std::string(1001, 'n')}, {}).error().field, "note");
}

TEST_F(Patients, EachSavingOfAProfileIsAVersion) {
  const std::int64_t patient = made("P-1").id;
  ProfileStore profiles(*database_);
  const Actor anna{"anna", "therapist", "rest", "script"};
  const auto first = profiles.create(patient, "usual", {{"speed_m_s_max", 0.1}, {"lean_dead_band_norm", 1.0 / 3}}, kStartUtc_ns, anna);
  ASSERT_TRUE(first.ok()) << first.error().message;
  EXPECT_EQ(first->settings.at("lean_dead_band_norm"), 1.0 / 3) << "to the last bit";
  EXPECT_EQ(profiles.create(patient, "usual", {}, kStartUtc_ns, anna).error().kind, ErrorKind::taken);
  EXPECT_EQ(profiles.create(99, "usual", {}, kStartUtc_ns, anna).error().kind, ErrorKind::not_found);
  const auto second =
      profiles.change(first->id, {.name = "slow", .settings = ProfileSettings{{"speed_m_s_max", 0.2}}}, kStartUtc_ns + 1, {}, first->tag);
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->version, 2);
  EXPECT_EQ(profiles.change(first->id, {.name = "x", .settings = {}}, 0, {}, first->tag).error().kind, ErrorKind::changed);
  const auto history = profiles.versions(first->id, {.limit = 1});
  EXPECT_EQ(history->items.at(0).version, 2);
  const auto older = profiles.versions(first->id, {.limit = 1, .before = history->next});
  EXPECT_EQ(older->items.at(0).actor, anna);
  EXPECT_EQ(older->items.at(0).settings.size(), 2U);
  EXPECT_FALSE(older->next);
  EXPECT_EQ(profiles.list(patient, {})->items.at(0).name, "slow");
  ASSERT_TRUE(profiles.remove(first->id, second->tag).ok());
  EXPECT_EQ(profiles.get(first->id).error().kind, ErrorKind::not_found);
  for (std::size_t i = 0; i < kMaxProfiles; ++i) ASSERT_TRUE(profiles.create(patient, std::to_string(i), {}, 0, {}).ok());
  EXPECT_EQ(profiles.create(patient, "one more", {}, 0, {}).error().kind, ErrorKind::wrong_state);
}

TEST_F(Patients, TheDifferenceOfTwoMomentsIsThatOfTheValuesThen) {
  // Against a table of all values at each moment, kept beside the log.
  std::mt19937 random(11);
  ParameterLog log(*database_);
  std::vector<std::array<double, 4>> moments{{0, 0, 0, 0}};
  for (std::int64_t t = 1; t <= 60; ++t) {
    auto values = moments.back();
    std::vector<ParameterChange> changes;
    for (unsigned k = random() % 3; k > 0; --k) {
      const std::uint32_t p = random() % 4U;
      const double value = static_cast<double>(random() % 3U);
      changes.push_back(
          {.utc_ns = t, .parameter = p, .name = "p" + std::to_string(p), .value = value, .before = values[p], .reason = "set"});
      values[p] = value;
    }
    ASSERT_TRUE(log.append(changes).ok());
    moments.push_back(values);
  }
  for (int round = 0; round < 200; ++round) {
    const std::size_t a = random() % 61U, b = a + random() % (61U - a);
    const auto told = log.between(static_cast<std::int64_t>(a), static_cast<std::int64_t>(b));
    ASSERT_TRUE(told.ok());
    std::size_t next = 0;
    for (std::uint32_t p = 0; p < 4; ++p) {
      if (moments[a][p] == moments[b][p]) continue;
      ASSERT_LT(next, told->size());
      EXPECT_EQ((*told)[next].parameter, p);
      EXPECT_EQ((*told)[next].from, moments[a][p]);
      EXPECT_EQ((*told)[next].to, moments[b][p]);
      ++next;
    }
    EXPECT_EQ(next, told->size());
  }
  const auto latest = log.latest();
  for (const auto& [p, value] : *latest) EXPECT_EQ(value, moments.back()[p]);
  EXPECT_EQ(log.list({.limit = 5, .name = "p1"})->items.size(), 5U);
  EXPECT_EQ(log.list({.user = "nobody"})->items.size(), 0U);
}

}  // namespace
}  // namespace hoist::db::test
