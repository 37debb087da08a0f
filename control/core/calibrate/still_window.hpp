// Means over a time without movement. A value that leaves its bound restarts the window, so that no mean contains a movement.
#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace hoist::core {

template <std::size_t kChannels>
class StillWindow {
 public:
  using Values = std::array<double, kChannels>;

  void restart() noexcept { ticks_ = 0; }

  /// One step's values. False when a value left its bound or was not a number: the window starts again with the next step.
  bool add(const Values& values, const Values& bounds) noexcept {
    if (ticks_ == 0) {
      low_ = high_ = first_ = values;
      sum_ = {};
    }
    for (std::size_t i = 0; i < kChannels; ++i) {
      low_[i] = values[i] < low_[i] ? values[i] : low_[i];
      high_[i] = values[i] > high_[i] ? values[i] : high_[i];
      // Written so that a NaN fails.
      if (!(high_[i] - low_[i] <= bounds[i]) || !std::isfinite(values[i])) {
        restart();
        return false;
      }
      // Against the first value, so that large counts lose nothing.
      sum_[i] += values[i] - first_[i];
    }
    ++ticks_;
    return true;
  }

  [[nodiscard]] std::uint32_t ticks() const noexcept { return ticks_; }
  /// 0 while the window is empty.
  [[nodiscard]] double mean(std::size_t channel) const noexcept {
    return ticks_ == 0 ? 0.0 : first_[channel] + sum_[channel] / static_cast<double>(ticks_);
  }
  [[nodiscard]] double spread(std::size_t channel) const noexcept { return ticks_ == 0 ? 0.0 : high_[channel] - low_[channel]; }

 private:
  Values low_{}, high_{}, first_{}, sum_{};
  std::uint32_t ticks_ = 0;
};

}  // namespace hoist::core
