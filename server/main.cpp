// hoist-server: reads the command line, prints the link, serves until it is told to end.
#include <pthread.h>
#include <signal.h>
#include <sys/stat.h>

#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "control/contract/program_version.hpp"
#include "server/app.hpp"
#include "server/settings.hpp"

int main(int argc, char** argv) {
  using namespace hoist::server;
  ::umask(077);  // what this program writes is about patients or decides how hard they may be pushed: for its own user only
  Settings settings;
  std::string error;
  if (!parse_settings(std::vector<std::string>(argv + 1, argv + argc), settings, error)) {
    std::cerr << "hoist-server: " << error << "\n";
    return 2;
  }
  if (settings.help) {
    std::cout << usage();
    return 0;
  }
  if (settings.version) {
    std::cout << "hoist-server " << hoist::contract::program_version() << "\n";
    return 0;
  }
  // Signals are taken by one thread that waits for them, so that no handler runs in the middle of anything.
  sigset_t signals;
  sigemptyset(&signals);
  sigaddset(&signals, SIGINT);
  sigaddset(&signals, SIGTERM);
  sigaddset(&signals, SIGHUP);
  pthread_sigmask(SIG_BLOCK, &signals, nullptr);
  signal(SIGPIPE, SIG_IGN);

  App app(settings);
  if (!app.start(error)) {
    std::cerr << "hoist-server: " << error << "\n";
    return 1;
  }
  std::cout << "Open " << app.link() << std::endl;
  std::thread waiter([&] {
    int got = 0;
    while (sigwait(&signals, &got) == 0 && got == SIGHUP) app.look_at_certificate();
    app.stop();
  });
  waiter.detach();
  app.run();
  return 0;
}
