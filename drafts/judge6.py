p='firmware/sim/plant.hpp'; s=open(p).read()
s=s.replace('''  void set_shove(double forward_n, double turn_n_m) { shove_n_ = forward_n, shove_n_m_ = turn_n_m; }
''','''  void set_shove(double forward_n, double turn_n_m) { shove_n_ = forward_n, shove_n_m_ = turn_n_m; }
  [[nodiscard]] double shove_n() const { return shove_n_; }
  [[nodiscard]] double shove_n_m() const { return shove_n_m_; }
''')
open(p,'w').write(s)
p='tests/chaos/judge/truth.cpp'; s=open(p).read()
s=s.replace('''  const double ahead_n = push.forward_n + downhill_n, twist_n = push.turn_n_m / machine.track_width_m;
''','''  const double ahead_n = push.forward_n + downhill_n + plant.shove_n();
  const double twist_n = (push.turn_n_m + plant.shove_n_m()) / machine.track_width_m;
''')
open(p,'w').write(s)
h=open('tests/chaos/faults.hpp').read()
kinds=[('both_shorted','nothing'),('cable_cut','any_node'),('hands','nothing'),('faint','nothing'),('over_voltage','nothing'),('sill','nothing'),('step_down','nothing'),('strap_cut','nothing')]
h=h.replace('  skid,\n  count','  skid,\n'+''.join('  %s,\n'%k for k,_ in kinds)+'  count')
h=h.replace('''    KindInfo{Kind::skid, "skid", Target::nothing, false, false},
''','''    KindInfo{Kind::skid, "skid", Target::nothing, false, false},
'''+''.join('    KindInfo{Kind::%s, "%s", Target::%s, false, false},\n'%(k,k,t) for k,t in kinds))
open('tests/chaos/faults.hpp','w').write(h)
d=open('tests/chaos/judge/deadlines.cpp').read()
by={'both_shorted':'"runaway; beside its command"','cable_cut':'kSilence','hands':'"beside its command"','faint':'"leaning, dragged"','over_voltage':'"drive fails; drive drops"','sill':'"beside its command; steep, sloping"','step_down':'"steep, sloping"','strap_cut':'"dragged"'}
d=d.replace('''    Judged{Kind::skid, "slipping"},
''','''    Judged{Kind::skid, "slipping"},
'''+''.join('    Judged{Kind::%s, %s},\n'%(k,by[k]) for k,_ in kinds))
d=d.replace('''    if (board_.now(Kind::bridge_shorted, drive) && plant.supply_v() > 1.0) short_s_ = judged_s_;
''','''    if (shorted(drive) && plant.supply_v() > 1.0) short_s_ = judged_s_;
''')
d=d.replace("if (!moving && board_.now(Kind::bridge_shorted, drive) &&","if (!moving && shorted(drive) &&")
open('tests/chaos/judge/deadlines.cpp','w').write(d)
p='tests/chaos/judge/deadlines.hpp'; s=open(p).read()
s=s.replace('''  [[nodiscard]] bool stuck(contract::Node node)''','''  [[nodiscard]] bool shorted(contract::Node drive) const {
    return board_.now(Kind::bridge_shorted, drive) || board_.now(Kind::both_shorted);
  }
  [[nodiscard]] bool stuck(contract::Node node)''')
open(p,'w').write(s)
s=open('tests/chaos/session.cpp').read()
s=s.replace('''      case Kind::power_cut:
        world.plant().cut_power(on);
''','''      case Kind::both_shorted:
        // Full or half duty, either way.
        for (const sim::Side both : {sim::Side::left, sim::Side::right}) {
          const double duty_norm = (f.size < 0.5 ? -1.0 : 1.0) * (std::fmod(f.size, 0.5) < 0.25 ? 0.5 : 1.0);
          world.plant().short_bridge(both, on ? std::optional<double>(duty_norm) : std::nullopt);
        }
        break;
      case Kind::cable_cut:
        // One cable, two nodes.
        world.unplug(f.node, on);
        world.unplug(f.node == Node::tilt_base ? Node::drive_left : static_cast<Node>(static_cast<int>(f.node) + 1), on);
        break;
      case Kind::hands:
        // Someone pushes or holds the frame, with up to 120 N, and turns it.
        world.plant().set_shove(on ? (f.size - 0.5) * 240.0 : 0.0, on ? std::fmod(f.size * 7.0, 1.0) * 20.0 - 10.0 : 0.0);
        break;
      case Kind::faint:
        // Legs without strength, hanging nearly upright: up to 8 degrees.
        if (on) world.patient().hang(0.112 * f.size);
        break;
      case Kind::over_voltage:
        // Braking into full batteries: 30 to 36 V at the drives.
        world.plant().force_battery(on ? std::optional<double>(30.0 + 6.0 * f.size) : std::nullopt);
        break;
      case Kind::sill:
        // A door sill holds both wheels back and lifts the front.
        world.plant().set_shove(on ? -40.0 - 120.0 * f.size : 0.0, 0.0);
        world.plant().tilt_floor(on ? -0.07 * f.size : 0.0, world.plant().platform().psi_rad);
        break;
      case Kind::step_down:
        // Up to 5 cm on half a metre of wheelbase.
        world.plant().tilt_floor(on ? 0.1 * f.size : 0.0, world.plant().platform().psi_rad);
        break;
      case Kind::strap_cut:
        // The body is no longer in the harness: the bar goes back to the middle.
        on ? world.hold_bar(0.0, 0.0, 0.0) : world.strap_in();
        break;
      case Kind::power_cut:
        world.plant().cut_power(on);
''',1)
s=s.replace('''return board_.ever(Kind::trip) || board_.ever(Kind::collapse) || board_.ever(Kind::hang) || loop''','''return board_.ever(Kind::trip) || board_.ever(Kind::collapse) || board_.ever(Kind::hang) || board_.ever(Kind::faint) ||
           loop''')
open('tests/chaos/session.cpp','w').write(s)
