#include "db/report/pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <ranges>

#include "db/store/exercise_json.hpp"
#include "db/store/session_reader.hpp"

namespace hoist::db::report {

namespace {

struct Point {
  double x = 0, y = 0;
};
using Line = std::vector<Point>;

// Of a page: thousandths of a millimetre serve no one.
std::string at(double value) {
  std::array<char, 32> out{};
  std::snprintf(out.data(), out.size(), "%.1f", value);
  return out.data();
}

std::string opened(const char* style, double width, double height, const std::string& label) {
  return "<svg class=\"" + std::string(style) + "\" viewBox=\"0 0 " + at(width) + " " + at(height) + "\" role=\"img\" aria-label=\"" +
         escaped(label) + "\">";
}

// The floor on a page: x to the right, y up.
class Floor {
 public:
  explicit Floor(const Line& first) : low_(first.front()), high_(first.front()) {}
  void take(const Line& line) {
    for (const Point& point : line) {
      low_ = {std::min(low_.x, point.x), std::min(low_.y, point.y)};
      high_ = {std::max(high_.x, point.x), std::max(high_.y, point.y)};
    }
  }
  void close(double room_m, double most) {
    low_ = {low_.x - room_m, low_.y - room_m};
    high_ = {high_.x + room_m, high_.y + room_m};
    scale_ = most / std::max(high_.x - low_.x, high_.y - low_.y);
  }
  [[nodiscard]] double width() const { return (high_.x - low_.x) * scale_; }
  [[nodiscard]] double height() const { return (high_.y - low_.y) * scale_; }
  [[nodiscard]] std::string line(const Line& points, const char* style) const {
    std::string out = "<polyline fill=\"none\" " + std::string(style) + " points=\"";
    for (const Point& point : points) out += at((point.x - low_.x) * scale_) + "," + at((high_.y - point.y) * scale_) + " ";
    return out + "\"/>";
  }
  [[nodiscard]] std::string grid() const {
    // A line each metre; a walk through a hall has none, they would be grey all over.
    constexpr double kMost_m = 60;
    std::string out;
    if (std::max(high_.x - low_.x, high_.y - low_.y) > kMost_m) return out;
    const char* style = "stroke=\"#ddd\" stroke-width=\"1\"";
    for (double x = std::ceil(low_.x); x <= high_.x; ++x) out += line({{x, low_.y}, {x, high_.y}}, style);
    for (double y = std::ceil(low_.y); y <= high_.y; ++y) out += line({{low_.x, y}, {high_.x, y}}, style);
    return out;
  }

 private:
  Point low_, high_;
  double scale_ = 1;
};

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

Result<std::string> path_picture(Database& database, const SessionInfo& session, const std::string& label) {
  constexpr double kMost = 420, kRoom_m = 0.5;
  const auto walked = walked_line(database, session.id);
  if (!walked) return walked.error();
  if (walked->empty()) return std::string();
  const Line planned = planned_line(session.exercise_json);
  Floor floor(*walked);
  floor.take(*walked);
  floor.take(planned);
  floor.close(kRoom_m, kMost);
  std::string out = opened("path", floor.width(), floor.height(), label) + floor.grid();
  if (!planned.empty()) out += floor.line(planned, "stroke=\"#555\" stroke-width=\"1.5\" stroke-dasharray=\"4 4\"");
  return out + floor.line(*walked, "stroke=\"#1a4f8b\" stroke-width=\"2\"") + "</svg>";
}

std::string progress_picture(const MetricInfo& figure, const std::vector<ProgressPoint>& points, const std::string& label,
                             Language language) {
  constexpr double kWidth = 320, kHeight = 130, kLeft = 60, kTop = 12, kInnerWidth = 240, kInnerHeight = 90;
  std::vector<double> values;
  for (const ProgressPoint& point : points)
    if (point.value) values.push_back(*point.value);
  if (values.size() < 2) return {};
  const auto [low, high] = std::ranges::minmax(values);
  const double bottom = low, span = high > low ? high - low : 1.0;
  const auto x = [&](std::size_t i) { return at(kLeft + kInnerWidth * static_cast<double>(i) / static_cast<double>(points.size() - 1)); };
  const auto height = [&](double value) { return kTop + kInnerHeight * (1 - (value - bottom) / span); };
  const auto text = [](const std::string& left, double top, const char* anchor, const std::string& words) {
    return "<text x=\"" + left + "\" y=\"" + at(top) + "\" text-anchor=\"" + anchor + "\">" + escaped(words) + "</text>";
  };
  const auto mark = [&](double value) {
    return text(at(kLeft - 8), height(value) + 4, "end", number_text(value * screen_factor(figure), figure.digits, language));
  };
  std::string path, dots;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!points[i].value) continue;
    const std::string y = at(height(*points[i].value));
    path += (i > 0 && points[i - 1].value ? "L" : "M") + x(i) + " " + y;
    dots += "<circle cx=\"" + x(i) + "\" cy=\"" + y + "\" r=\"3\" fill=\"#1a4f8b\"/>";
  }
  std::string out = opened("progress", kWidth, kHeight, label) + mark(high);
  if (high > low) out += mark(low);
  out += "<path fill=\"none\" stroke=\"#1a4f8b\" stroke-width=\"1.5\" d=\"" + path + "\"/>" + dots;
  return out + text(x(0), kHeight - 6, "start", points.front().day) + text(x(points.size() - 1), kHeight - 6, "end", points.back().day) +
         "</svg>";
}

}  // namespace hoist::db::report
