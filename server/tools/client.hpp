// One program such as Foxglove Studio or a ROS page. What it may do is the same in both protocols and judged by actions/: take control, drive,
// stop, tune. The protocol (foxglove.hpp, rosbridge.hpp) only reads and writes its messages.
#pragma once
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "server/actions/actions.hpp"
#include "server/http/auth.hpp"
#include "server/tools/topics.hpp"
#include "server/ws/connection.hpp"

namespace hoist::server {

class ToolClient;

// What a client needs of the hub that owns it.
class ToolOwner {
 public:
  [[nodiscard]] virtual Services& services() const = 0;
  virtual void use(Session& session) = 0;
  // Its sign-in has run out.
  [[nodiscard]] virtual bool over(const Session& session) const = 0;
  virtual void remove(const ToolClient* client) = 0;
  // Another one for each run of the core: within one, time never runs backwards.
  [[nodiscard]] virtual const std::string& session_id() const = 0;

 protected:
  ~ToolOwner() = default;
};

inline constexpr std::uint64_t kToolMessagesPerSecond = 120;
// Frames of values that wait: all topics of about three steps.
inline constexpr std::size_t kToolQueue = 3 * kToolTopics;
// A tool sends nothing when its user releases the button, so this much silence is a release. Two messages at 10 Hz fit; the core's own limit is
// remote_stop_age_s.
inline constexpr std::uint64_t kToolSilence_ns = 200'000'000;
// The most a tool may ask for, whatever the driving limit is: its button was not made for a machine with a person in it.
inline constexpr double kToolSpeed_m_s = 0.2, kToolTurn_rad_s = 0.4;

struct ToolService {
  std::string_view name;
  contract::Role role;
  std::string_view doc;
};
enum class ServiceId : std::uint8_t { stop, take_control, release_control, drive, stand_by };
// In the order of ServiceId; each is a std_srvs/srv/Trigger.
inline constexpr std::array<ToolService, 5> kToolServices{
    {{"/hoist/stop", contract::Role::viewer, "STOP"},
     {"/hoist/take_control", contract::Role::therapist, "Take control; only when nobody else has it"},
     {"/hoist/release_control", contract::Role::therapist, "Give control back"},
     {"/hoist/drive", contract::Role::therapist, "Begin driving by /cmd_vel; needs control"},
     {"/hoist/stand_by", contract::Role::viewer, "End motion"}}};
[[nodiscard]] std::optional<ServiceId> find_tool_service(std::string_view name);

enum class ToolLevel : std::uint8_t { info, warning, error };

class ToolClient : public SocketConnection {
 public:
  ToolClient(ToolOwner& hub, std::unique_ptr<Stream> stream, SessionPtr session, std::uint32_t number, std::shared_ptr<void> seat);

  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] bool holds_lease() const;
  [[nodiscard]] contract::Role role() const { return session_->role; }
  [[nodiscard]] const Session& session() const { return *session_; }

  // Once, a moment after the handshake (ToolHub::kGreeting_ns).
  virtual void greet() {}
  // The topics that this client watches.
  [[nodiscard]] virtual TopicMask watched() const = 0;
  virtual void show(Moment& moment) = 0;
  virtual void show_parameters() = 0;
  // Each poll: the timeout of hold-to-run, and while it drives the ping whose answer dates its driving commands.
  void watch(std::uint64_t now_ns, std::uint64_t newest_ns);

  // State of the hub about this client.
  std::uint64_t opened_ns = 0;
  bool greeted = false;

 protected:
  virtual void on_message(const nlohmann::json& message, const std::optional<std::string>& repeated) = 0;
  virtual void tell(ToolLevel level, const std::string& text) = 0;
  // STOP in this protocol's words, judged before anything else.
  [[nodiscard]] virtual bool is_stop(const nlohmann::json& message) const = 0;

  void on_text(std::string text) override;
  void on_pong(std::string_view payload) override;
  void on_leave() override;

  [[nodiscard]] ToolOwner& hub() const { return hub_; }
  [[nodiscard]] Services& services() const;
  [[nodiscard]] Asker asker() const;
  // A geometry_msgs/Twist; nothing: it could not be read.
  struct Twist {
    double linear_x_m_s = 0, angular_z_rad_s = 0;
  };
  void drive(const std::optional<Twist>& twist);
  [[nodiscard]] static std::optional<Twist> read_twist(const nlohmann::json& message);
  void call(ServiceId service, OutcomeDone done);
  // For the parameters as this client was last shown them.
  void set_parameters(const nlohmann::json& values, OutcomeDone done);
  void parameters_shown();
  // False: the connection is being closed, perhaps for more messages than may be.
  [[nodiscard]] bool allow();
  // Calls `then` when this client is still there.
  template <typename Self, typename Then>
  [[nodiscard]] OutcomeDone later(Then then) {
    return [weak = std::weak_ptr(std::static_pointer_cast<Self>(shared_from_this())), then = std::move(then)](const Outcome& outcome) {
      if (const auto held = weak.lock()) then(*held, outcome);
    };
  }

 private:
  void let_go();

  ToolOwner& hub_;
  SessionPtr session_;
  std::uint32_t number_;
  std::uint64_t allowance_ = kToolMessagesPerSecond;
  std::uint64_t allowance_ns_;
  std::uint32_t version_ = 0;  // of the parameters it was shown; 0: none yet
  std::uint64_t echo_ns_ = 0;  // newest step that it has answered a ping about
  Hand hand_;
  std::uint64_t twist_ns_ = 0;   // when its last driving message came
  std::uint64_t let_go_ns_ = 0;  // when silence last counted as a release
  std::uint64_t told_ns_ = 0;    // when a refusal was last told
};

// Why it was refused, in one sentence.
[[nodiscard]] std::string sentence_of(const Outcome& outcome);
[[nodiscard]] const nlohmann::json& tool_field(const nlohmann::json& message, const char* name);

}  // namespace hoist::server
