// Means over a time in which nothing moved. Whatever strays further than its bound begins the time anew, so that no mean ever contains a
// movement.
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

  /// One step's values. False when one of them strayed by more than its bound, or was no number: the time begins with the next step.
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
