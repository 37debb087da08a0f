import re
# --- simulator
b=open('firmware/sim/battery.hpp').read()
b=b.replace('''    const double half_v = which == 0 ? params_.difference_v / 2.0 : -params_.difference_v / 2.0;
''','''    const double apart_v = params_.difference_v + weaker_v_;
    const double half_v = which == 0 ? apart_v / 2.0 : -apart_v / 2.0;
''')
b=b.replace('''  void force(std::optional<double> both_v) { forced_v_ = both_v; }
''','''  void force(std::optional<double> both_v) { forced_v_ = both_v; }
  /// One battery is worn out: battery 1 falls behind battery 0 by this much more than usual, with the same sum.
  void weaken(double by_v) { weaker_v_ = by_v; }
''')
b=b.replace('  double current_a_{};\n','  double current_a_{}, weaker_v_{};\n')
open('firmware/sim/battery.hpp','w').write(b)
p=open('firmware/sim/plant.hpp').read()
p=p.replace('''  void force_battery(std::optional<double> both_v) { battery_.force(both_v); }
''','''  void force_battery(std::optional<double> both_v) { battery_.force(both_v); }
  void weaken_battery(double by_v) { battery_.weaken(by_v); }
''')
open('firmware/sim/plant.hpp','w').write(p)
w=open('firmware/sim/world.hpp').read()
w=w.replace('''  /// Wheels lose the floor from now on, for a moment.
''','''  /// Wrong assembly. A wheel's motor mounted the other way round, with its encoder: the drive cannot see it. The two struts' sensors, or the two
  /// encoders, plugged the wrong way round. A strut's sensor mounted the other way round: forward and left show backward and right.
  void mirror_wheel(contract::Node node, bool mirrored);
  void swap_struts(bool swapped);
  void swap_encoders(bool swapped);
  void reverse_sensor(contract::Node node, bool reversed);
  /// Wheels lose the floor from now on, for a moment.
''')
open('firmware/sim/world.hpp','w').write(w)
c=open('firmware/sim/world.cpp').read()
c=c.replace('''  bool read_imu(Node node, firmware::ImuSample& sample) {
    const auto place = place_of(node);
''','''  bool read_imu(Node node, firmware::ImuSample& sample) {
    const auto place = place_seen_by(node);
    if (!read_place(place, sample)) return false;
    if (reversed_[static_cast<std::size_t>(place_of(node))]) {
      sample.ax_m_s2 = -sample.ax_m_s2;
      sample.ay_m_s2 = -sample.ay_m_s2;
      sample.alpha_rate_rad_s = -sample.alpha_rate_rad_s;
      sample.beta_rate_rad_s = -sample.beta_rate_rad_s;
    }
    return true;
  }
  bool read_place(Place place, firmware::ImuSample& sample) {
''')
c=c.replace('''  std::int32_t encoder_counts(Node node) {
    Encoder& encoder = encoders_[static_cast<std::size_t>(side_of(node))];
    const std::int32_t raw = plant_.encoder_counts(side_of(node));
''','''  std::int32_t encoder_counts(Node node) {
    Encoder& encoder = encoders_[static_cast<std::size_t>(side_of(node))];
    const Side wired = swapped_encoders_ ? other(side_of(node)) : side_of(node);
    const bool mirrored = mirrored_[static_cast<std::size_t>(wired)];
    const std::int32_t raw = mirrored ? negative(plant_.encoder_counts(wired)) : plant_.encoder_counts(wired);
    if (std::exchange(encoder.wired, wired) != wired || std::exchange(encoder.mirrored, mirrored) != mirrored) encoder.raw = raw;
''')
c=c.replace('''  float motor_current_a(Node node) { return static_cast<float>(plant_.motor_current_a(side_of(node))); }
''','''  float motor_current_a(Node node) {
    const double current_a = plant_.motor_current_a(side_of(node));
    return static_cast<float>(mirrored_[static_cast<std::size_t>(side_of(node))] ? -current_a : current_a);
  }
''')
c=c.replace('''  void set_bridge(Node node, bool enabled, float duty_norm) { plant_.set_bridge(side_of(node), enabled, static_cast<double>(duty_norm)); }
''','''  void set_bridge(Node node, bool enabled, float duty_norm) {
    const double duty = static_cast<double>(duty_norm);
    plant_.set_bridge(side_of(node), enabled, mirrored_[static_cast<std::size_t>(side_of(node))] ? -duty : duty);
  }
''')
c=c.replace('''  void break_encoder(Node node, World::EncoderFault fault) { encoders_''','''  void mirror_wheel(Node node, bool mirrored) { mirrored_[static_cast<std::size_t>(side_of(node))] = mirrored; }
  void swap_struts(bool swapped) { swapped_struts_ = swapped; }
  void swap_encoders(bool swapped) { swapped_encoders_ = swapped; }
  void reverse_sensor(Node node, bool reversed) { reversed_[static_cast<std::size_t>(place_of(node))] = reversed; }
  void break_encoder(Node node, World::EncoderFault fault) { encoders_''')
c=c.replace('''    World::EncoderFault fault{World::EncoderFault::none};
  };
  struct Ailment {''','''    World::EncoderFault fault{World::EncoderFault::none};
    Side wired{Side::left};
    bool mirrored{false};
  };
  static constexpr Side other(Side side) { return side == Side::left ? Side::right : Side::left; }
  // Of a counter that wraps.
  static constexpr std::int32_t negative(std::int32_t counts) { return static_cast<std::int32_t>(0U - static_cast<std::uint32_t>(counts)); }
  [[nodiscard]] Place place_seen_by(Node node) const {
    const Place place = place_of(node);
    if (!swapped_struts_ || place == Place::chassis) return place;
    return place == Place::left_strut ? Place::right_strut : Place::left_strut;
  }
  struct Ailment {''')
c=c.replace('''  std::array<Encoder, 2> encoders_{};
};''','''  std::array<Encoder, 2> encoders_ = [] {
    std::array<Encoder, 2> both{};
    both[1].wired = Side::right;
    return both;
  }();
  std::array<bool, 2> mirrored_{};
  std::array<bool, kPlaceCount> reversed_{};
  bool swapped_struts_{false}, swapped_encoders_{false};
};''')
c=c.replace('''void World::set_frame_fault(''','''void World::mirror_wheel(Node node, bool mirrored) {
  if (contract::kNodes[index(node)].kind == contract::NodeKind::drive) parts_->machine.mirror_wheel(node, mirrored);
}
void World::swap_struts(bool swapped) { parts_->machine.swap_struts(swapped); }
void World::swap_encoders(bool swapped) { parts_->machine.swap_encoders(swapped); }
void World::reverse_sensor(Node node, bool reversed) {
  if (contract::kNodes[index(node)].kind == contract::NodeKind::tilt) parts_->machine.reverse_sensor(node, reversed);
}
void World::set_frame_fault(''',1)
open('firmware/sim/world.cpp','w').write(c)
