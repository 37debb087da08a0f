// All open WebSockets: hears what the core says, encodes each frame once, shares it among all clients.
#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "server/http/auth.hpp"
#include "server/link/core_desk.hpp"
#include "server/live/client.hpp"
#include "server/record/recorder.hpp"
#include "server/services.hpp"
#include "server/stream/stream.hpp"
#include "server/ws/frame.hpp"

namespace hoist::server {

// Samples of one ordinary telemetry frame: 20 frames per second.
inline constexpr std::size_t kBatchSamples = 5;

// What the hoist is driven by may not be older: a client in control gets at least each fifth step.
inline constexpr std::uint32_t kDriverEvery_ticks = 5;
// What a returning client is sent of the steps it has missed: less than half of its queue, else its oldest ones count as missing.
inline constexpr std::size_t kRefill_bytes = 96 * 1024;

class Feed;

class Hub final : public CoreListener, public ClientOwner {
 public:
  Hub();
  ~Hub() override;
  void set_services(Services& services, Auth& auth);

  void on_core(bool connected) override;
  void on_ticks(std::span<const contract::TickRecord> records, std::uint64_t lost) override;
  void on_parameters(const contract::ParamsInForce& parameters) override;
  void on_lease(std::uint32_t epoch, std::uint32_t holder) override;
  void on_event(const contract::Event& event) override;

  // Once per poll: what has changed is told; once a second each client is pinged, and a silent one is dropped.
  void poll(std::uint64_t now_ns);
  // How many samples complete the batch.
  [[nodiscard]] std::size_t samples_missing() const { return kBatchSamples - batched_; }
  // Every client gets a close frame; the sockets end by themselves.
  void close_all();

  // A WebSocket whose handshake is done becomes a client.
  void open(std::unique_ptr<Stream> stream, std::shared_ptr<void> seat, SessionPtr session, const std::string& address);
  // Closes the WebSockets of these sessions, whatever they do: the core then sees a driver leave and stops.
  void close_sockets(const std::function<bool(const Session&)>& of, std::string_view reason);
  // Ends the stream of this client, and takes none of its sign-in before then. False: there is no such client.
  bool cut(std::uint32_t client, std::uint64_t until_ns);
  void use(Session& session) override;
  [[nodiscard]] bool over(const Session& session) const override;
  void add(std::shared_ptr<Client> client);
  void remove(const Client* client) override;
  void choose(Client& client, const StreamChoice& choice, const std::optional<Resume>& resume) override;
  // How often a client was looked at (for tests).
  [[nodiscard]] std::uint64_t visits() const { return visits_; }
  [[nodiscard]] std::size_t clients() const { return clients_.size(); }
  [[nodiscard]] Services& services() const override { return *services_; }

 private:
  void broadcast(const SharedFrame& frame);
  // Sends what the feeds have; `urgent` = false: only those that show each step by itself.
  void send_batches(bool urgent);
  void tell_lost(std::uint64_t to);
  // Puts a client on the feed that gives what it has asked for and may have.
  void assign(Client& client);
  void begin_anew();
  void refill(Client& client, std::uint64_t last_tick);
  void tell_walk();
  void tell_lease();
  static void tell_lease(Client& client, nlohmann::json message);
  void poll_asks(std::uint64_t now_ns);
  void tell_recording();
  void tell_jobs(std::uint64_t now_ns);
  void close_ended();

  Services* services_ = nullptr;
  Auth* auth_ = nullptr;
  SessionPtr cut_;  // whose stream is cut, until then
  std::uint64_t cut_until_ns_ = 0;
  std::vector<std::shared_ptr<Client>> clients_;
  bool ending_ = false;
  std::vector<std::shared_ptr<Feed>> feeds_;
  std::size_t batched_ = 0;  // steps since the last batch
  std::optional<contract::TickRecord> last_;
  std::uint64_t run_ = 0;  // of the core that last_ is of
  std::uint64_t visits_ = 0;
  std::uint64_t visited_ns_ = 0;         // when the clients were last looked at
  std::uint64_t recording_changes_ = 0;  // of the recorder, as told last
  std::uint64_t people_changes_ = 0;     // of the accounts
  std::optional<contract::StoreProblem> store_problem_, stops_problem_;
  std::optional<int> slow_percent_;
  RecordingStatus told_;
  std::string told_problem_;  // why the core is not connected
  std::vector<StandingNotice> told_notices_;
  std::uint64_t told_asks_ = 0;                         // changes of who asks for the lease
  std::uint64_t told_jobs_ = 0, told_jobs_ns_ = 0;      // changes of the jobs, and when they were told
  std::uint64_t told_update_ = 0, told_update_ns_ = 0;  // changes of the firmware desk, and when they were told
};

// With the names that the numbers stand for.
[[nodiscard]] nlohmann::json event_json(const contract::Event& event);

}  // namespace hoist::server
