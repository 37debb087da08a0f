// The figures people walk: square and figure of eight (Fig. 7 of the paper, sizes D34) and a straight. One definition for the
// simulator, the metrics, the console's exercises and the trajectory mode.
//
// square: counter-clockwise from (-side/2, -side/2), heading 0.
// eight:  arcs of radius R about (+c, 0) and (-c, 0), joined by straights that cross at the origin; starts at the origin, heading
//         asin(R/c), right arc (clockwise) first. R = c gives two tangent circles.
// straight: from the origin along +x; open. Figures are closed where nothing else is said.
// circle: counter-clockwise from the origin, heading 0, about (0, R).
// slalom: from the origin, heading 0, about four poles on a line parallel to x, the first one passed on its left; open.
// own: along the points as they were drawn; open or closed.
// A square may have round corners; it then begins in the middle of its first side. mirrored() turns any figure over to its right-hand twin.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>

#include "control/contract/own_line.hpp"

namespace hoist::contract {

enum class PathShape : unsigned char { kSquare, kEight, kStraight, kCircle, kSlalom, kOwn };

/// A place on the figure. psi is not wrapped: it grows by a full turn with each lap of the square.
struct PathPose {
  double x_m{};
  double y_m{};
  double psi_rad{};
  double kappa_per_m{};  ///< curvature, positive to the left
};

/// Sizes the paper's 5 x 5 m room suggests (D34).
inline constexpr double kSquareSide_m = 3.2;
inline constexpr double kEightCentre_m = 1.0;
inline constexpr double kEightRadius_m = 0.8;
inline constexpr double kStraightLength_m = 10.0;
/// A slalom crosses the line of its poles at 60 degrees: its curves have this share of the spacing as radius, 1 / (2 sin 60 degrees), and
/// pass each pole at half of that. Between its bumpers the hoist is 0.8 m wide: it keeps 0.18 m from poles 2 m apart, 0.1 m at 1.75 m.
inline constexpr double kSlalomCurve_norm = 0.57735026918962576;
/// How far ahead the projection looks, so that the crossing of the eight is never jumped (D27).
inline constexpr double kProjectionWindow_m = 0.5;

/// A figure made of lines and arcs. Copyable, no heap, every function pure.
class ReferencePath {
 public:
  /// Sizes must be finite and > 0; the eight also needs radius <= centre. Anything else gives a path with valid() false, whose length is
  /// 0 and whose every pose is the origin.
  [[nodiscard]] static ReferencePath square(double side_m = kSquareSide_m) {
    ReferencePath path(PathShape::kSquare);
    if (!usable(side_m)) return path;
    const double half_m = side_m / 2.0;
    path.start_ = {-half_m, -half_m, 0.0, 0.0};
    for (int side = 0; side < 4; ++side) {
      path.add_line(side_m);
      if (side < 3) path.turn_corner(kQuarter_rad);
    }
    path.lap_turn_rad_ = 4.0 * kQuarter_rad;
    return path;
  }

  /// A square whose corners are arcs of this radius, 0 < corner_radius <= side / 2.
  [[nodiscard]] static ReferencePath round_square(double side_m, double corner_radius_m) {
    ReferencePath path(PathShape::kSquare);
    const double half_m = side_m / 2.0;
    if (!usable(side_m) || !usable(corner_radius_m) || corner_radius_m > half_m) return path;
    path.start_ = {0.0, -half_m, 0.0, 0.0};
    const double straight_m = half_m - corner_radius_m;
    for (int side = 0; side < 4; ++side) {
      if (straight_m > 0.0) path.add_line(side == 0 ? straight_m : 2.0 * straight_m);
      path.add_arc(corner_radius_m * kQuarter_rad, 1.0 / corner_radius_m);
    }
    if (straight_m > 0.0) path.add_line(straight_m);
    path.lap_turn_rad_ = 4.0 * kQuarter_rad;
    return path;
  }

  [[nodiscard]] static ReferencePath circle(double radius_m) {
    ReferencePath path(PathShape::kCircle);
    if (!usable(radius_m)) return path;
    path.start_ = {0.0, 0.0, 0.0, 0.0};
    path.add_arc(2.0 * kHalf_rad * radius_m, 1.0 / radius_m);
    path.lap_turn_rad_ = 2.0 * kHalf_rad;
    return path;
  }

  [[nodiscard]] static ReferencePath eight(double centre_m = kEightCentre_m, double radius_m = kEightRadius_m) {
    ReferencePath path(PathShape::kEight);
    if (!usable(centre_m) || !usable(radius_m) || radius_m > centre_m) return path;
    const double slope_rad = std::asin(radius_m / centre_m);
    const double straight_m = std::sqrt(centre_m * centre_m - radius_m * radius_m);
    const double arc_m = radius_m * (kHalf_rad + 2.0 * slope_rad);
    path.start_ = {0.0, 0.0, slope_rad, 0.0};
    if (straight_m > 0.0) path.add_line(straight_m);
    path.add_arc(arc_m, -1.0 / radius_m);
    if (straight_m > 0.0) path.add_line(2.0 * straight_m);
    path.add_arc(arc_m, 1.0 / radius_m);
    if (straight_m > 0.0) path.add_line(straight_m);
    return path;
  }

  [[nodiscard]] static ReferencePath straight(double length_m = kStraightLength_m) {
    ReferencePath path(PathShape::kStraight);
    if (!usable(length_m)) return path;
    path.start_ = {0.0, 0.0, 0.0, 0.0};
    path.add_line(length_m);
    return path;
  }

  /// Round four poles of this spacing, first to the left; it ends five spacings ahead, along x again.
  [[nodiscard]] static ReferencePath slalom(double spacing_m) {
    ReferencePath path(PathShape::kSlalom);
    if (!usable(spacing_m)) return path;
    path.start_ = {0.0, 0.0, 0.0, 0.0};
    const double radius_m = kSlalomCurve_norm * spacing_m, swing_m = kSixth_rad * radius_m;
    path.add_arc(swing_m, 1.0 / radius_m);
    for (int pole = 0; pole < 4; ++pole) path.add_arc(2.0 * swing_m, (pole % 2 == 0 ? -1.0 : 1.0) / radius_m);
    path.add_arc(swing_m, -1.0 / radius_m);
    return path;
  }

  /// Along the points. Corners are arcs of this radius, or of the largest below it that leaves both neighbours their half of a straight; below
  /// kSharp_m, and with a radius of 0, they are sharp. A closed line whose first corner is round begins in the middle of its first straight.
  [[nodiscard]] static ReferencePath own(const OwnLine& line, double corner_radius_m) {
    ReferencePath path(PathShape::kOwn);
    path.closed_ = line.closed;
    if (!walkable(line) || !std::isfinite(corner_radius_m) || corner_radius_m < 0.0) return path;
    const std::size_t edges = line.closed ? line.count : line.count - 1;
    std::array<OwnCorner, kOwnPointsMost> corners{};
    for (std::size_t i = line.closed ? 0 : 1; i < edges; ++i) corners[i] = own_corner(line, i, corner_radius_m);
    const double heading_rad = own_heading_rad(line, 0);
    const double first_m = corners[0].cut_m > 0.0 ? own_edge_m(line, 0) / 2.0 : 0.0;
    path.start_ = {line.points[0].x_m + first_m * std::cos(heading_rad), line.points[0].y_m + first_m * std::sin(heading_rad), heading_rad,
                   0.0};
    for (std::size_t i = 0; i < edges; ++i) {
      const OwnCorner& next = corners[(i + 1) % line.count];
      path.add_straight(own_edge_m(line, i) - (i == 0 ? first_m : corners[i].cut_m) - next.cut_m);
      const bool last = i + 1 == edges;
      // A sharp corner at the start is turned at the begin of the next lap.
      if (!(last && !(next.cut_m > 0.0))) path.turn_own(next);
      path.lap_turn_rad_ += next.turn_rad;
    }
    if (first_m > 0.0) path.add_straight(first_m - corners[0].cut_m);
    path.lap_turn_rad_ = line.closed ? std::round(path.lap_turn_rad_ / (2.0 * kHalf_rad)) * 2.0 * kHalf_rad : 0.0;
    return path;
  }

  /// The same figure with left and right exchanged.
  [[nodiscard]] ReferencePath mirrored() const {
    ReferencePath path = *this;
    for (Segment& segment : path.segments_) flip(segment.begin);
    flip(path.start_);
    flip(path.pen_);
    path.lap_turn_rad_ = -lap_turn_rad_;
    return path;
  }

  [[nodiscard]] PathShape shape() const { return shape_; }
  [[nodiscard]] bool valid() const { return count_ > 0; }
  /// Whether the end is the start again, so that it has laps.
  [[nodiscard]] bool closed() const { return closed_; }
  /// Length of one lap, or of an open figure.
  [[nodiscard]] double length_m() const { return length_m_; }

  /// The place at arc length s_m from the start; on a corner, the edge that follows (D27). Laps are counted for closed figures; an open
  /// one holds s_m to its ends. Not finite gives the start.
  [[nodiscard]] PathPose pose(double s_m) const {
    if (!valid()) return {};
    const Place place = locate(s_m);
    PathPose at = segments_[place.segment].at(place.along_m);
    at.psi_rad += place.lap * lap_turn_rad_;
    return at;
  }

  /// What lies ahead of s_m: how far the curvature stays as it is, and what it is after that (0 behind the end of an open figure).
  struct Ahead {
    double kappa_per_m{};
    double left_m{};
    double next_kappa_per_m{};
  };
  [[nodiscard]] Ahead ahead(double s_m) const {
    if (!valid()) return {};
    const Place place = locate(s_m);
    const Segment& here = segments_[place.segment];
    const bool last = place.segment + 1 == count_;
    const double next = !last ? segments_[place.segment + 1].begin.kappa_per_m : (closed() ? segments_[0].begin.kappa_per_m : 0.0);
    return {here.begin.kappa_per_m, here.length_m - place.along_m, next};
  }

  /// Nearest place to (x, y) with arc length in [from_m, from_m + window_m]: never backward, never across the crossing. Of equally near
  /// places the first. Something not finite returns from_m.
  [[nodiscard]] double project(double x_m, double y_m, double from_m, double window_m = kProjectionWindow_m) const {
    if (!valid() || !std::isfinite(x_m) || !std::isfinite(y_m) || !std::isfinite(from_m) || !(window_m > 0.0)) return from_m;
    // One lap is enough to see every place once.
    const double reach_m = window_m < length_m_ ? window_m : length_m_;
    double begin_m = from_m;
    if (!closed()) begin_m = from_m < 0.0 ? 0.0 : (from_m > length_m_ ? length_m_ : from_m);
    const double end_m = begin_m + reach_m;
    Place place = locate(begin_m);
    double best_s_m = begin_m;
    double best_square = HUGE_VAL;
    double piece_s_m = begin_m;
    // A window of at most a lap touches each segment at most twice.
    for (std::size_t piece = 0; piece < 2 * kSegmentLimit; ++piece) {
      const Segment& segment = segments_[place.segment];
      const double left_m = end_m - piece_s_m;
      const double rest_m = segment.length_m - place.along_m;
      const double to_m = rest_m < left_m ? segment.length_m : place.along_m + left_m;
      const double nearest_m = segment.nearest(x_m, y_m, place.along_m, to_m);
      const PathPose at = segment.at(nearest_m);
      const double square = (at.x_m - x_m) * (at.x_m - x_m) + (at.y_m - y_m) * (at.y_m - y_m);
      if (square < best_square) {
        best_square = square;
        best_s_m = piece_s_m + (nearest_m - place.along_m);
      }
      if (rest_m >= left_m) break;
      ++place.segment;
      if (place.segment == count_) {
        if (!closed()) break;
        place.segment = 0;
        place.lap += 1.0;
      }
      place.along_m = 0.0;
      // Taken from the table, not summed up, so that laps of projection do not drift.
      piece_s_m = place.lap * length_m_ + segments_[place.segment].begin_m;
    }
    return best_s_m < from_m && closed() ? from_m : best_s_m;
  }

 private:
  static constexpr double kHalf_rad = 3.14159265358979323846;
  static constexpr double kQuarter_rad = kHalf_rad / 2.0;
  static constexpr double kSixth_rad = kHalf_rad / 3.0;
  /// Of an own line: a straight and an arc for each point, and the first straight once more.
  static constexpr std::size_t kSegmentLimit = 2 * kOwnPointsMost + 1;
  /// A corner of a smaller radius is sharp.
  static constexpr double kSharp_m = 0.05;
  /// A place this close before a joint is on the joint, so that rounding does not decide which edge follows.
  static constexpr double kJoint_m = 1e-9;

  struct Segment {
    PathPose begin;
    double begin_m{};
    double length_m{};

    [[nodiscard]] PathPose at(double along_m) const {
      const double kappa = begin.kappa_per_m;
      if (kappa == 0.0) {
        return {begin.x_m + along_m * std::cos(begin.psi_rad), begin.y_m + along_m * std::sin(begin.psi_rad), begin.psi_rad, 0.0};
      }
      const double psi_rad = begin.psi_rad + kappa * along_m;
      return {begin.x_m + (std::sin(psi_rad) - std::sin(begin.psi_rad)) / kappa,
              begin.y_m - (std::cos(psi_rad) - std::cos(begin.psi_rad)) / kappa, psi_rad, kappa};
    }

    /// Distance along this segment, inside [from_m, to_m], that is nearest to (x, y).
    [[nodiscard]] double nearest(double x_m, double y_m, double from_m, double to_m) const {
      const double kappa = begin.kappa_per_m;
      if (kappa == 0.0) {
        const double along_m = (x_m - begin.x_m) * std::cos(begin.psi_rad) + (y_m - begin.y_m) * std::sin(begin.psi_rad);
        return along_m < from_m ? from_m : (along_m > to_m ? to_m : along_m);
      }
      const double centre_x_m = begin.x_m - std::sin(begin.psi_rad) / kappa;
      const double centre_y_m = begin.y_m + std::cos(begin.psi_rad) / kappa;
      const double out_x_m = x_m - centre_x_m;
      const double out_y_m = y_m - centre_y_m;
      // Exactly at the centre every place is equally near: the first.
      if (out_x_m == 0.0 && out_y_m == 0.0) return from_m;
      const double sense = kappa > 0.0 ? 1.0 : -1.0;
      // Angle gone round since the middle of the piece, so that the wrap of atan2 falls on the far side, where it decides nothing.
      const double middle_m = (from_m + to_m) / 2.0;
      const double middle_rad = begin.psi_rad + kappa * middle_m;
      const double radial_x = sense * std::sin(middle_rad);
      const double radial_y = -sense * std::cos(middle_rad);
      const double off_rad = sense * std::atan2(radial_x * out_y_m - radial_y * out_x_m, radial_x * out_x_m + radial_y * out_y_m);
      const double along_m = middle_m + off_rad / std::fabs(kappa);
      return along_m < from_m ? from_m : (along_m > to_m ? to_m : along_m);
    }
  };

  struct Place {
    std::size_t segment{};
    double along_m{};
    double lap{};
  };

  explicit ReferencePath(PathShape shape) : shape_(shape), closed_(shape != PathShape::kStraight && shape != PathShape::kSlalom) {}

  [[nodiscard]] static bool usable(double size_m) { return std::isfinite(size_m) && size_m > 0.0; }

  static void flip(PathPose& pose) {
    pose.y_m = -pose.y_m;
    pose.psi_rad = -pose.psi_rad;
    pose.kappa_per_m = -pose.kappa_per_m;
  }

  [[nodiscard]] PathPose pen() const { return count_ == 0 ? start_ : pen_; }

  void add(double length_m, double kappa_per_m) {
    Segment& segment = segments_[count_];
    segment.begin = pen();
    segment.begin.kappa_per_m = kappa_per_m;
    segment.begin_m = length_m_;
    segment.length_m = length_m;
    pen_ = segment.at(length_m);
    length_m_ += length_m;
    ++count_;
  }
  void add_line(double length_m) { add(length_m, 0.0); }
  void add_arc(double length_m, double kappa_per_m) { add(length_m, kappa_per_m); }
  void turn_corner(double by_rad) { pen_.psi_rad += by_rad; }

  /// The corner of an own line at one of its points. cut_m of both its straights belong to the arc; 0 = sharp.
  struct OwnCorner {
    double turn_rad{}, cut_m{}, radius_m{};
  };
  [[nodiscard]] static bool walkable(const OwnLine& line) {
    if (line.count < own_points_least(line.closed) || line.count > kOwnPointsMost) return false;
    for (std::size_t i = 0; i < line.count; ++i) {
      const FloorPoint& point = line.points[i];
      // Written so that a NaN fails.
      if (!(std::fabs(point.x_m) <= kOwnReach_m && std::fabs(point.y_m) <= kOwnReach_m)) return false;
      if ((line.closed || i + 1 < line.count) && !(own_edge_m(line, i) > 0.0)) return false;
    }
    return true;
  }
  [[nodiscard]] static double own_heading_rad(const OwnLine& line, std::size_t from) {
    const FloorPoint &a = line.points[from], &b = line.points[(from + 1) % line.count];
    return std::atan2(b.y_m - a.y_m, b.x_m - a.x_m);
  }
  [[nodiscard]] static OwnCorner own_corner(const OwnLine& line, std::size_t at, double radius_m) {
    const std::size_t before = (at + line.count - 1) % line.count;
    const double turn_rad = std::remainder(own_heading_rad(line, at) - own_heading_rad(line, before), 2.0 * kHalf_rad);
    const double slope = std::tan(std::fabs(turn_rad) / 2.0);
    const double before_m = own_edge_m(line, before), after_m = own_edge_m(line, at);
    const double room_m = (before_m < after_m ? before_m : after_m) / 2.0;
    const double cut_m = radius_m * slope < room_m ? radius_m * slope : room_m;
    if (!(slope > 0.0) || !(cut_m / slope > kSharp_m)) return {turn_rad, 0.0, 0.0};
    return {turn_rad, cut_m, cut_m / slope};
  }
  void turn_own(const OwnCorner& corner) {
    if (corner.cut_m > 0.0)
      add_arc(corner.radius_m * std::fabs(corner.turn_rad), (corner.turn_rad > 0.0 ? 1.0 : -1.0) / corner.radius_m);
    else
      turn_corner(corner.turn_rad);
  }
  /// Where two arcs meet, rounding leaves no straight between them.
  void add_straight(double length_m) {
    if (length_m > kJoint_m) add_line(length_m);
  }

  [[nodiscard]] Place locate(double s_m) const {
    Place place;
    if (!std::isfinite(s_m)) return place;
    double along_m = s_m;
    if (closed()) {
      place.lap = std::floor(s_m / length_m_);
      along_m = s_m - place.lap * length_m_;
      if (along_m >= length_m_ - kJoint_m) {
        place.lap += 1.0;
        along_m = 0.0;
      }
    } else if (along_m > length_m_) {
      along_m = length_m_;
    }
    if (along_m < 0.0) along_m = 0.0;
    while (place.segment + 1 < count_ && along_m >= segments_[place.segment + 1].begin_m - kJoint_m) ++place.segment;
    const double inside_m = along_m - segments_[place.segment].begin_m;
    place.along_m = inside_m < 0.0 ? 0.0 : inside_m;
    return place;
  }

  PathShape shape_;
  bool closed_;
  std::array<Segment, kSegmentLimit> segments_{};
  std::size_t count_{};
  double length_m_{};
  double lap_turn_rad_{};
  PathPose start_{};
  PathPose pen_{};
};

}  // namespace hoist::contract
