// The figures on the floor and the factors of Tables II and III.
#include <array>
#include <nlohmann/json.hpp>

#include "control/contract/reference_path.hpp"
#include "db/metrics/cross_correlation.hpp"
#include "db/metrics/evaluate.hpp"
#include "db/metrics/normalised_ise.hpp"
#include "db/metrics/table_mean.hpp"
#include "deploy/tools/hoist/laws/law_list.hpp"

namespace hoist::tool {

using contract::ReferencePath;
using nlohmann::json;

namespace {

json optional_out(const std::optional<double>& value) { return value ? number_out(*value) : json(nullptr); }

ReferencePath read_path(Fields& in) {
  const std::string shape = in.text("shape");
  if (shape == "square") return ReferencePath::square(in.number("a", kPositive));
  if (shape == "eight") {
    const double centre_m = in.number("c", kPositive);
    const double radius_m = in.number("R", {.low = 0.0, .high = centre_m, .low_open = true});
    return ReferencePath::eight(centre_m, radius_m);
  }
  if (shape == "straight") return ReferencePath::straight(in.number("length", kPositive));
  throw Refusal("shape: \"" + shape + "\", must be square, eight or straight");
}

json xcorr0(Fields& in, Fields&) {
  const auto x = in.numbers("x");
  const auto y = in.numbers("y");
  same_length("y", y.size(), "x", x.size());
  return {{"C", optional_out(db::cross_correlation(x, y))}};
}

json j_n(Fields& in, Fields&) {
  const auto x = in.numbers("x");
  const auto y = in.numbers("y");
  const auto psi = in.numbers("psi");
  const auto xr = in.numbers("xr");
  const auto yr = in.numbers("yr");
  const auto psir = in.numbers("psir");
  same_length("y", y.size(), "x", x.size());
  same_length("psi", psi.size(), "x", x.size());
  same_length("xr", xr.size(), "x", x.size());
  same_length("yr", yr.size(), "x", x.size());
  same_length("psir", psir.size(), "x", x.size());
  const auto length_m = in.optional_number("L", kPositive);
  const auto ise = db::normalised_ise({x, y, psi, xr, yr, psir}, length_m);
  if (!ise) return {{"J", nullptr}, {"L", number_out(length_m ? *length_m : db::polyline_length_m(xr, yr))}};
  return {{"J", ise->j}, {"L", ise->length_m}};
}

json table_mean(Fields& in, Fields&) {
  const auto rows = in.optional_table("rows");
  json mean = json::array();
  for (const auto& value : db::table_mean(rows)) mean.push_back(optional_out(value));
  return {{"mean", std::move(mean)}};
}

json path_pose(Fields& in, Fields&) {
  const auto path = read_path(in);
  const auto pose = path.pose(in.number("s"));
  return {{"x", pose.x_m}, {"y", pose.y_m}, {"psi", pose.psi_rad}, {"kappa", pose.kappa_per_m}, {"L", path.length_m()}};
}

json path_project(Fields& in, Fields&) {
  const auto path = read_path(in);
  const double window_m = in.number_or("window", contract::kProjectionWindow_m, kPositive);
  const auto x = in.numbers("x");
  const auto y = in.numbers("y");
  same_length("y", y.size(), "x", x.size());
  json s = json::array();
  double at_m = 0.0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    at_m = path.project(x[i], y[i], at_m, window_m);
    s.push_back(at_m);
  }
  return {{"s", std::move(s)}};
}

json evaluate(Fields& in, Fields&) {
  const auto path = read_path(in);
  const double dt_s = in.number("dt", kPositive);
  const auto x = in.numbers("x");
  const auto y = in.numbers("y");
  const auto psi = in.numbers("psi");
  const auto dpsi = in.numbers("dpsi");
  same_length("y", y.size(), "x", x.size());
  same_length("psi", psi.size(), "x", x.size());
  same_length("dpsi", dpsi.size(), "x", x.size());
  const double window_m = in.number_or("window", contract::kProjectionWindow_m, kPositive);
  if (x.empty()) throw Refusal("x: must have at least one element");
  const auto result = db::evaluate(path, {dt_s, x, y, psi, dpsi}, window_m);
  if (!result) throw Refusal("x, y, psi, dpsi: cannot be evaluated");
  json out = {{"C", optional_out(result->c)}, {"J", nullptr}, {"L", nullptr}};
  if (result->ise) {
    out["J"] = result->ise->j;
    out["L"] = result->ise->length_m;
  }
  return out;
}

constexpr std::array kLaws = {
    Law{"xcorr0", "factor C of Table II: correlation at zero lag, mean kept", "x, y: arrays", "", "C (null when undefined)", &xcorr0},
    Law{"J_N", "normalised squared error, equation (24)", "x, y, psi, xr, yr, psir: arrays; L m or null", "", "J, L", &j_n},
    Law{"table_mean", "last rows of Tables II and III", "rows: array of arrays, null is missing", "", "mean: array", &table_mean},
    Law{"path_pose", "a place on the figures of Fig. 7",
        "s: arc length m; shape: square with a, eight with c and R, or straight with length, m", "",
        "x, y m, psi rad (not wrapped), kappa 1/m, L m", &path_pose},
    Law{"path_project", "reference sample of each odometry sample", "x, y: arrays m; window m; shape as in path_pose", "",
        "s: array m, never decreasing", &path_project},
    Law{"evaluate", "C, J_N and L of a recorded run at its own sample rate",
        "x, y, psi, dpsi: arrays; dt s; window m; shape as in path_pose", "", "C, J, L", &evaluate},
};

}  // namespace

std::span<const Law> metric_laws() { return kLaws; }

}  // namespace hoist::tool
