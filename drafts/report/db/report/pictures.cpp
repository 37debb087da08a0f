#include "db/report/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::db::report {

namespace {

struct Point {
  double x = 0, y = 0;
};
using Line = std::vector<Point>;

std::string at(double value) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.1f", value);
  return out.data();
}

struct Box {
  Point low, high;
  void take(const Line& line) {
    for (const Point& point : line) {
      low = {std::min(low.x, point.x), std::min(low.y, point.y)};
      high = {std::max(high.x, point.x), std::max(high.y, point.y)};
    }
  }
};

std::string polyline(const Line& line, const Box& box, double scale, const char* style) {
  std::string out = "<polyline fill=\"none\" " + std::string(style) + " points=\"";
  for (const Point& point : line) out += at((point.x - box.low.x) * scale) + "," + at((box.high.y - point.y) * scale) + " ";
  return out + "\"/>";
}

// About 600 points of a session, whichever track it has.
Result<Line> walked_line(Database& database, SessionId session) {
  constexpr std::size_t kPoints = 600;
  const std::vector<std::string> fused{"fused_x_m", "fused_y_m"}, plain{"x_m", "y_m"};
  auto columns = SessionReader(database).overview(session, fused, kPoints);
  // Sessions from before the slip-repaired track have the encoders' own only.
  if (!columns && columns.error().kind == ErrorKind::bad_value) columns = SessionReader(database).overview(session, plain, kPoints);
  if (!columns) return columns.error();
  Line line;
  for (std::size_t i = 0; i < columns->from_s.size(); ++i)
    line.push_back({(columns->min[0][i] + columns->max[0][i]) / 2, (columns->min[1][i] + columns->max[1][i]) / 2});
  return line;
}

Line planned_line(const std::optional<std::string>& exercise) {
  constexpr int kPieces = 400;
  Line line;
  if (!exercise) return line;
  const contract::ReferencePath path = figure_of_stored(*exercise);
  if (!path.valid()) return line;
  for (int i = 0; i <= kPieces; ++i) {
    const contract::PathPose pose = path.pose(path.length_m() * std::min(static_cast<double>(i) / kPieces, 1.0 - 1e-12));
    line.push_back({pose.x_m, pose.y_m});
  }
  return line;
}

}  // namespace

Result<std::string> path_picture(Database& database, const SessionInfo& session) {
  constexpr double kWidth = 420, kRoom_m = 0.5, kMostLines = 60;
  const auto walked = walked_line(database, session.id);
  if (!walked) return walked.error();
  if (walked->empty()) return std::string();
  const Line planned = planned_line(session.exercise_json);
  Box box{walked->front(), walked->front()};
  box.take(*walked);
  box.take(planned);
  box = {{box.low.x - kRoom_m, box.low.y - kRoom_m}, {box.high.x + kRoom_m, box.high.y + kRoom_m}};
  const double wide_m = box.high.x - box.low.x, high_m = box.high.y - box.low.y;
  const double scale = kWidth / std::max(wide_m, high_m);
  std::string out = "<svg class=\"path\" viewBox=\"0 0 " + at(wide_m * scale) + " " + at(high_m * scale) + "\" role=\"img\">";
  if (std::max(wide_m, high_m) <= kMostLines) {
    for (double x = std::ceil(box.low.x); x <= box.high.x; ++x)
      out += polyline({{x, box.low.y}, {x, box.high.y}}, box, scale, "stroke=\"#ddd\" stroke-width=\"1\"");
    for (double y = std::ceil(box.low.y); y <= box.high.y; ++y)
      out += polyline({{box.low.x, y}, {box.high.x, y}}, box, scale, "stroke=\"#ddd\" stroke-width=\"1\"");
  }
  if (!planned.empty()) out += polyline(planned, box, scale, "stroke=\"#555\" stroke-width=\"1.5\" stroke-dasharray=\"2 4\"");
  return out + polyline(*walked, box, scale, "stroke=\"#1a4f8b\" stroke-width=\"2\"") + "</svg>";
}

std::string progress_picture(const MetricInfo& figure, const std::vector<ProgressPoint>& points, Language language) {
  constexpr double kWidth = 320, kHeight = 130, kLeft = 60, kTop = 12, kInnerWidth = 240, kInnerHeight = 90;
  if (points.size() < 2) return {};
  const auto [least, most] = std::ranges::minmax_element(points, {}, &ProgressPoint::value);
  const double low = least->value, span = most->value > low ? most->value - low : 1.0;
  const auto x = [&](std::size_t i) { return kLeft + kInnerWidth * static_cast<double>(i) / static_cast<double>(points.size() - 1); };
  const auto y = [&](double value) { return kTop + kInnerHeight * (1 - (value - low) / span); };
  std::string line, dots;
  for (std::size_t i = 0; i < points.size(); ++i) {
    line += at(x(i)) + "," + at(y(points[i].value)) + " ";
    dots += "<circle cx=\"" + at(x(i)) + "\" cy=\"" + at(y(points[i].value)) + "\" r=\"3\" fill=\"#1a4f8b\"/>";
  }
  const auto mark = [&](double value) {
    return "<text x=\"" + at(kLeft - 6) + "\" y=\"" + at(y(value) + 4) + "\" text-anchor=\"end\">" +
           number_text(value * screen_factor(figure), figure.digits, language) + "</text>";
  };
  const auto day = [&](std::size_t i, const char* anchor) {
    return "<text x=\"" + at(x(i)) + "\" y=\"" + at(kHeight - 6) + "\" text-anchor=\"" + anchor + "\">" + escaped(points[i].day) + "</text>";
  };
  std::string out = "<svg class=\"progress\" viewBox=\"0 0 " + at(kWidth) + " " + at(kHeight) + "\" role=\"img\" font-size=\"11\">";
  out += mark(most->value);
  if (most->value > low) out += mark(low);
  return out + "<polyline fill=\"none\" stroke=\"#1a4f8b\" stroke-width=\"1.5\" points=\"" + line + "\"/>" + dots + day(0, "start") +
         day(points.size() - 1, "end") + "</svg>";
}

}  // namespace hoist::db::report
