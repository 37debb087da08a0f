#include "deploy/tools/hoist/study/drawings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <tuple>
#include <vector>

#include "control/contract/exercises.hpp"
#include "control/contract/faults.hpp"
#include "control/core/law/pfp.hpp"
#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::tool::study {

namespace {

struct Point {
  double x = 0, y = 0;
};

// Shapes in a box on the page; y points up inside it.
class Svg {
 public:
  Svg(double width, double height) : width_(width), height_(height) {}
  struct Box {
    double left, top, width, height;  // on the page
    Point low, high;                  // what it shows
  };
  void line(const Box& box, const std::vector<Point>& points, const char* style) {
    body_ += "<polyline fill=\"none\" " + std::string(style) + " points=\"";
    for (const Point& point : points) body_ += number(x(box, point.x)) + "," + number(y(box, point.y)) + " ";
    body_ += "\"/>\n";
  }
  void arrow(const Box& box, const Point& from, const Point& to) {
    body_ += "<line x1=\"" + number(x(box, from.x)) + "\" y1=\"" + number(y(box, from.y)) + "\" x2=\"" + number(x(box, to.x)) + "\" y2=\"" +
             number(y(box, to.y)) + "\" stroke=\"#b3261e\" stroke-width=\"1\" marker-end=\"url(#head)\"/>\n";
  }
  void text(double at_x, double at_y, const std::string& words, const char* anchor = "start") {
    body_ += "<text x=\"" + number(at_x) + "\" y=\"" + number(at_y) + "\" text-anchor=\"" + anchor + "\">" + escaped(words) + "</text>\n";
  }
  [[nodiscard]] static double x(const Box& box, double value) {
    return box.left + (value - box.low.x) / (box.high.x - box.low.x) * box.width;
  }
  [[nodiscard]] static double y(const Box& box, double value) {
    return box.top + (box.high.y - value) / (box.high.y - box.low.y) * box.height;
  }
  [[nodiscard]] std::string whole(const std::string& title) const {
    const std::string size = number(width_) + "\" height=\"" + number(height_);
    return "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"" + size + "\" viewBox=\"0 0 " + number(width_) + " " + number(height_) +
           "\" font-family=\"sans-serif\" font-size=\"12\">\n<title>" + title +
           "</title>\n<defs><marker id=\"head\" viewBox=\"0 0 6 6\" refX=\"5\" refY=\"3\" markerWidth=\"5\" markerHeight=\"5\" "
           "orient=\"auto\"><path d=\"M0,0 L6,3 L0,6 z\" fill=\"#b3261e\"/></marker></defs>\n<rect width=\"100%\" height=\"100%\" "
           "fill=\"white\"/>\n" +
           body_ + "</svg>\n";
  }

 private:
  // Codes are typed by people.
  static std::string escaped(const std::string& words) {
    std::string out;
    for (const char c : words) out += c == '<' ? "&lt;" : c == '&' ? "&amp;" : std::string(1, c);
    return out;
  }
  static std::string number(double value) {
    std::array<char, 32> out{};
    std::snprintf(out.data(), out.size(), "%.2f", value);
    return out.data();
  }
  double width_, height_;
  std::string body_;
};

constexpr const char* kThin = "stroke=\"#888\" stroke-width=\"1\"";
constexpr const char* kDotted = "stroke=\"#555\" stroke-width=\"1.2\" stroke-dasharray=\"2 3\"";
constexpr const char* kSolid = "stroke=\"#1a4f8b\" stroke-width=\"1.6\"";

std::vector<Point> points_of(const contract::ReferencePath& path) {
  constexpr int kPieces = 600;
  std::vector<Point> out;
  for (int i = 0; i <= kPieces; ++i) {
    const contract::PathPose at = path.pose(path.length_m() * std::min(static_cast<double>(i) / kPieces, 1.0 - 1e-12));
    out.push_back({at.x_m, at.y_m});
  }
  return out;
}

// A square around the shape, with room for those who leave it.
Svg::Box box_of(const std::vector<Point>& shape, double left, double top, double size) {
  constexpr double kRoom_m = 0.5;
  Point low = shape.front(), high = shape.front();
  for (const Point& point : shape) {
    low = {std::min(low.x, point.x), std::min(low.y, point.y)};
    high = {std::max(high.x, point.x), std::max(high.y, point.y)};
  }
  const double half = std::max(high.x - low.x, high.y - low.y) / 2 + kRoom_m;
  const Point middle{(low.x + high.x) / 2, (low.y + high.y) / 2};
  return {left, top, size, size, {middle.x - half, middle.y - half}, {middle.x + half, middle.y + half}};
}

// One recorded run over its reference.
db::Status draw_run(db::Database& database, db::SessionId session, const Svg::Box& box, Svg& svg) {
  constexpr std::size_t kEach = 10, kArrowEach = 120;  // samples: at 0.25 m/s a point each 2.5 cm, a pixel of the page
  constexpr double kArrow_m = 0.5;                     // for a turn of the whole range
  const std::vector<std::string> names{"fused_x_m", "fused_y_m", "fused_psi_rad", "turn_norm", "mode"};
  const db::Result<db::Columns> columns = db::SessionReader(database).read_columns(session, names);
  if (!columns) return columns.error();
  const auto& [x_m, y_m, psi_rad, turn_norm, mode] =
      std::tie(columns->values[0], columns->values[1], columns->values[2], columns->values[3], columns->values[4]);
  std::vector<Point> track;
  for (std::size_t i = 0; i < x_m.size(); i += kEach) track.push_back({x_m[i], y_m[i]});
  svg.line(box, track, kSolid);
  for (std::size_t i = 0; i < x_m.size(); i += kArrowEach) {
    if (!contract::kModes[static_cast<std::size_t>(mode[i])].moving) continue;
    // To the left of the track for a turn to the left, as long as the turn is large.
    const double aside_m = kArrow_m * turn_norm[i];
    svg.arrow(box, {x_m[i], y_m[i]}, {x_m[i] - aside_m * std::sin(psi_rad[i]), y_m[i] + aside_m * std::cos(psi_rad[i])});
  }
  return {};
}

}  // namespace

std::string braking_drawing() {
  constexpr double kDeadband = 0.05, kStep_s = 0.01;
  Svg svg(520, 380);
  const Svg::Box box{60, 30, 420, 290, {0, -2.5}, {1, 1.5}};  // the logarithm of seconds
  svg.line(box, {{0, -2.5}, {1, -2.5}}, kThin);
  svg.line(box, {{0, -2.5}, {0, 1.5}}, kThin);
  for (int decade = -2; decade <= 1; ++decade) {
    svg.line(box, {{0, static_cast<double>(decade)}, {1, static_cast<double>(decade)}}, "stroke=\"#ddd\" stroke-width=\"1\"");
    svg.text(54, Svg::y(box, decade) + 4, decade < 0 ? (decade == -1 ? "0.1 s" : "0.01 s") : (decade == 0 ? "1 s" : "10 s"), "end");
  }
  for (const double share : {0.0, 0.2, 0.4, 0.6, 0.8, 1.0}) svg.text(Svg::x(box, share), 338, std::to_string(share).substr(0, 3), "middle");
  for (const double l_dec : {2.0, 5.0, 10.0, 20.0, 50.0}) {
    std::vector<Point> curve;
    for (int i = 1; i <= 400; ++i) {
      const double u = kDeadband + (1 - kDeadband) * i / 400.0;
      curve.push_back({u, std::clamp(std::log10(law::tau_brake_s(u, kDeadband, l_dec, kStep_s)), -2.5, 1.5)});
    }
    svg.line(box, curve, kSolid);
    svg.text(Svg::x(box, 1.0) + 4, Svg::y(box, curve.back().y) + 4, std::to_string(static_cast<int>(l_dec)));
  }
  svg.text(270, 360, "lean against the motion, share of its range; L_dec beside each curve", "middle");
  svg.text(60, 20, "Fig. 2: time constant while braking, D = 0.05");
  return svg.whole("Time constant while braking");
}

std::string shapes_drawing(const Protocol& protocol) {
  std::vector<contract::ExerciseShape> shapes;
  for (const Run& run : protocol.runs)
    if (std::ranges::find(shapes, run.shape) == shapes.end()) shapes.push_back(run.shape);
  Svg svg(40 + 260 * static_cast<double>(shapes.size()), 320);
  svg.text(20, 20, "Fig. 7: shapes");
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const contract::ReferencePath path = contract::figure_of(contract::usual_exercise(shapes[i]));
    const std::vector<Point> points = points_of(path);
    const Svg::Box box = box_of(points, 20 + 260 * static_cast<double>(i), 40, 240);
    svg.line(box, points, kSolid);
    const contract::PathPose start = path.pose(0.0);
    svg.arrow(box, {start.x_m, start.y_m}, {start.x_m + 0.4 * std::cos(start.psi_rad), start.y_m + 0.4 * std::sin(start.psi_rad)});
    svg.text(box.left + 120, 300,
             std::string(contract::find_exercise(shapes[i])->title_en) + ", " + std::to_string(path.length_m()).substr(0, 5) + " m",
             "middle");
  }
  return svg.whole("Shapes that are walked");
}

db::Result<std::string> tracks_drawing(db::Database& database, const Protocol& protocol, const Results& results) {
  constexpr double kSize = 230;
  const auto columns = static_cast<double>(protocol.drawn_subjects.size()), rows = static_cast<double>(protocol.drawn_runs.size());
  Svg svg(90 + (kSize + 10) * columns, 50 + (kSize + 10) * rows);
  svg.text(20, 20, "Fig. 8: tracks (solid) over the reference (dotted), arrows: turn wanted by the pelvis");
  for (std::size_t r = 0; r < protocol.drawn_runs.size(); ++r) {
    const Run* run = protocol.find(protocol.drawn_runs[r]);
    const double top = 40 + (kSize + 10) * static_cast<double>(r);
    svg.text(10, top + kSize / 2, "run " + std::to_string(run->number) + (run->by_patient ? "*" : ""));
    for (std::size_t c = 0; c < protocol.drawn_subjects.size(); ++c) {
      const auto subject = static_cast<std::size_t>(protocol.drawn_subjects[c] - 1);
      const std::vector<Point> points = points_of(contract::figure_of(contract::usual_exercise(run->shape)));
      const Svg::Box box = box_of(points, 70 + (kSize + 10) * static_cast<double>(c), top, kSize);
      svg.line(box, points, kDotted);
      if (subject < results.subjects.size()) svg.text(box.left + 4, top + 12, results.subjects[subject]);
      const auto at = results.runs.find({subject, run->number});
      if (at == results.runs.end()) continue;
      if (db::Status drawn = draw_run(database, at->second, box, svg); !drawn) return drawn.error();
    }
  }
  return svg.whole("Tracks of the study");
}

}  // namespace hoist::tool::study
