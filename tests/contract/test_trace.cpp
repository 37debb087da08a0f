// Every hazard has a guard and a test, and the committed page is up to date.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "deploy/tools/trace/trace.hpp"

namespace hoist::trace {
namespace {

const std::filesystem::path kTop = HOIST_SOURCE_DIR;

TEST(Trace, NoHazardIsWithoutAnswerOrTest) {
  const auto found = holes(scan_tree(kTop), kTop);
  for (const std::string& hole : found) ADD_FAILURE() << hole;
}

TEST(Trace, ThePageIsUpToDate) {
  std::ifstream in(kTop / kPage, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
  EXPECT_TRUE(text == page(scan_tree(kTop))) << kPage << " is out of date: run deploy/dev trace --write";
}

TEST(Trace, HolesAreFound) {
  const Scan nothing;
  const auto found = holes(nothing, kTop);
  const auto has = [&](std::string_view part) {
    for (const std::string& hole : found)
      if (hole.find(part) != std::string::npos) return true;
    return false;
  };
  EXPECT_TRUE(has("H15 (the patient falls or stumbles) has no test that names it"));
  EXPECT_TRUE(has("no test names Fault::fall_detected"));
  Scan stranger;
  stranger.mentions.push_back({32, "tests/x.cpp", "A.B"});
  const auto more = holes(stranger, kTop);
  EXPECT_NE(std::find(more.begin(), more.end(), "tests/x.cpp: A.B names the hazard H32, which does not exist"), more.end());
  EXPECT_FALSE(holes(scan_tree(kTop), "/nowhere").empty()) << "the guards' files must exist";
}

TEST(Trace, MentionsBelongToTheirTest) {
  Scan scan;
  scan_file("tests/x.cpp",
            "// About H1: a word at the top of a file is no test.\n"
            "#include <x>\n"
            "row = {\"H4\", 1};\n"
            "// H9\n"
            "TEST(Suite, ThisOne) {\n"
            "  go();  // H10\n"
            "  EXPECT(Fault::fall_detected);\n"
            "}\n"
            "TEST_F(Other, H15_H16Both) {\n"
            "  // the rest: H2\n"
            "  path(\"H340\", AH3, H1.5);\n"
            "}\n",
            scan);
  std::string all;
  for (const Mention& m : scan.mentions) all += "H" + std::to_string(m.hazard) + "=" + m.test + ";";
  EXPECT_EQ(all, "H4=;H9=Suite.ThisOne;H10=Suite.ThisOne;H15=Other.H15_H16Both;H16=Other.H15_H16Both;H2=Other.H15_H16Both;");
  EXPECT_EQ(scan.tested_faults, std::set<std::string>{"fall_detected"});
  Scan others;
  scan_file("web/test/x.test.ts", "  it('lets go', () => {\n    // H19\n    x();\n", others);
  scan_file("tests/system/x.py", "# H5\ndef stops_alone():\n    pass\n", others);
  ASSERT_EQ(others.mentions.size(), 2U);
  EXPECT_EQ(others.mentions[0].test, "lets go");
  EXPECT_EQ(others.mentions[1].test, "stops_alone");
}

}  // namespace
}  // namespace hoist::trace
