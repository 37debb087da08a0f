// The hoist's own certificates by the clock and the addresses; what other programs make of them: tests/system/own_authority.py.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "server/stream/device_ca.hpp"
#include "server/stream/tls_keeper.hpp"
#include "tests/support/temporary_folder.hpp"

namespace hoist::test {
namespace {

using server::DeviceCa;
using server::TlsKeeper;
using Issued = DeviceCa::Issued;
constexpr std::int64_t kStart_utc_s = DeviceCa::kEarliest_utc_s + 100 * DeviceCa::kDay_s;

class DeviceCaTest : public ::testing::Test {
 protected:
  std::unique_ptr<DeviceCa> open(std::int64_t utc_s = kStart_utc_s) {
    return DeviceCa::open(folder_ / "tls", {{"hoist.local"}, {"192.168.7.2"}, {"10.1.0.0/16", "fd00::/8"}}, utc_s, error_);
  }
  std::string content() {
    std::ifstream in(folder_ / "tls" / "server.pem");
    return {std::istreambuf_iterator<char>(in), {}};
  }
  TemporaryFolder folder_;
  std::string error_;
};

TEST_F(DeviceCaTest, IssuesAnewWhenTheCertificateEndsSoonOrTheClockIsOutsideOfIt) {
  const auto ca = open();
  ASSERT_TRUE(ca) << error_;
  const auto at = [&](std::int64_t utc_s) { return ca->issue({}, utc_s, error_); };
  EXPECT_EQ(at(kStart_utc_s), Issued::renewed);
  const std::string first = content();
  EXPECT_EQ(at(kStart_utc_s), Issued::still_good);
  EXPECT_EQ(at(kStart_utc_s + 366 * DeviceCa::kDay_s), Issued::still_good) << "30 days are left";
  EXPECT_EQ(content(), first);
  EXPECT_EQ(at(kStart_utc_s + 368 * DeviceCa::kDay_s), Issued::renewed);
  EXPECT_NE(content(), first);
  EXPECT_EQ(at(kStart_utc_s), Issued::renewed) << "the clock went back, before the certificate begins";
  EXPECT_EQ(at(0), Issued::failed) << "a clock that is not set";
  EXPECT_NE(error_.find("not set"), std::string::npos);
  EXPECT_EQ(at(kStart_utc_s), Issued::still_good) << "and nothing was spoilt";
}

// H21: without a server no tablet can say STOP.
TEST_F(DeviceCaTest, ACertificateThatCannotBeRenewedServesOn_H21) {
  const auto keeper = [&](std::int64_t utc_s) {
    return std::make_unique<TlsKeeper>(
        open(), [utc_s] { return utc_s; }, nullptr);
  };
  EXPECT_FALSE(keeper(0)->first(error_)) << "none was issued yet";
  EXPECT_NE(error_.find("not set"), std::string::npos);
  error_.clear();
  const auto begun = keeper(kStart_utc_s);
  ASSERT_TRUE(begun->first(error_)) << error_;
  const auto restarted = keeper(0);
  EXPECT_TRUE(restarted->first(error_)) << error_;
  EXPECT_EQ(error_, "");
  EXPECT_EQ(restarted->ca().signed_names(), begun->ca().signed_names());
  // A certificate of another authority is not used.
  const auto other = DeviceCa::open(folder_ / "other", {{"hoist.local"}, {}, {}}, kStart_utc_s, error_);
  ASSERT_EQ(other->issue({}, kStart_utc_s, error_), Issued::renewed) << error_;
  std::filesystem::copy_file(folder_ / "other" / "server.pem", folder_ / "tls" / "server.pem",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_FALSE(keeper(0)->first(error_));
}

TEST_F(DeviceCaTest, FollowsTheAddressesThatTheAuthorityMaySign) {
  const auto ca = open();
  ASSERT_TRUE(ca) << error_;
  const auto with = [&](std::vector<std::string> addresses) { return ca->issue(addresses, kStart_utc_s, error_); };
  EXPECT_EQ(with({}), Issued::renewed);
  EXPECT_EQ(with({"172.16.0.1", "192.168.7.3", "2001:db8::1"}), Issued::still_good) << "none of them";
  EXPECT_EQ(with({"10.1.2.3", "fd00::5", "172.16.0.1"}), Issued::renewed);
  EXPECT_EQ(ca->signed_names(),
            (std::vector<std::string>{"hoist.local", "localhost", "127.0.0.1", "::1", "192.168.7.2", "10.1.2.3", "fd00::5"}));
  EXPECT_EQ(with({"10.1.2.3", "fd00::5"}), Issued::still_good);
  EXPECT_EQ(with({"10.1.2.4"}), Issued::renewed) << "another lease of the network's";
}

TEST_F(DeviceCaTest, KeepsItsAuthorityAndRepairsItsCertificate) {
  const auto first = open();
  ASSERT_TRUE(first) << error_;
  ASSERT_EQ(first->issue({}, kStart_utc_s, error_), Issued::renewed);
  const auto again = open(kStart_utc_s + 1);
  ASSERT_TRUE(again) << error_;
  EXPECT_EQ(again->fingerprint(), first->fingerprint());
  EXPECT_EQ(again->fingerprint().size(), 95U);
  EXPECT_EQ(again->issue({}, kStart_utc_s, error_), Issued::still_good);
  std::ofstream(folder_ / "tls" / "server.pem") << "half of a file";
  EXPECT_EQ(again->issue({}, kStart_utc_s, error_), Issued::renewed);
  // A certificate of another authority is none.
  const auto other = DeviceCa::open(folder_ / "other", {{"hoist.local"}, {"192.168.7.2"}, {}}, kStart_utc_s, error_);
  ASSERT_TRUE(other) << error_;
  ASSERT_EQ(other->issue({}, kStart_utc_s, error_), Issued::renewed);
  std::filesystem::copy_file(folder_ / "other" / "server.pem", folder_ / "tls" / "server.pem",
                             std::filesystem::copy_options::overwrite_existing);
  EXPECT_EQ(again->issue({}, kStart_utc_s, error_), Issued::renewed);
}

TEST_F(DeviceCaTest, MakesNoAuthorityByAClockThatIsNotSet) {
  EXPECT_FALSE(open(86'400));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "tls" / "authority.pem"));
}

}  // namespace
}  // namespace hoist::test
