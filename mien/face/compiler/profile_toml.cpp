#include "mien/face/compiler/profile_toml.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/nearest_word.h"
#include "mien/core/toml.h"

namespace mien::face {
namespace {

/// Of a sum of shares: numbers written by hand, in decimals.
constexpr double kShareTolerance = 1e-6;

std::vector<std::string> strings(std::span<const std::string_view> names) {
  return {names.begin(), names.end()};
}

std::vector<std::string> inner_names() {
  std::vector<std::string> names = strings(kShapeNames);
  names.emplace_back(inner_name(kShapeCount));
  return names;
}

/// Reads one file; its functions stop at the first thing that is wrong.
class Reader {
 public:
  Reader(const std::string& where, std::span<const ProfileTable> earlier)
      : where_(where), earlier_(earlier) {}

  Result<ProfileTable> read(const toml::table& file) {
    MIEN_TRY(
        only_keys(file, {"name", "title", "source", "extends", "map", "share", "none", "lacks"}, where_));
    MIEN_TRY(read_head(file));
    MIEN_TRY(each(file, "map", &Reader::read_gains));
    MIEN_TRY(each(file, "none", &Reader::read_none));
    MIEN_TRY(each(file, "share", &Reader::read_share));
    MIEN_TRY(each(file, "lacks", &Reader::read_lack));
    MIEN_TRY(check_all_are_told());
    MIEN_TRY(check_shares());
    return std::move(table_);
  }

 private:
  /// Text that is there and not empty. Errors: malformed.
  [[nodiscard]] Result<std::string> text(const toml::node* node, std::string_view name) const {
    if (node == nullptr) return fail(ErrorCode::malformed, fmt::format("'{}' is missing", name), where_);
    const auto value = node->value_exact<std::string>();
    if (!value || value->empty())
      return fail(ErrorCode::malformed, fmt::format("'{}' is no text", excerpt(name)), place(where_, *node),
                  "write it in quotes");
    return *value;
  }

  [[nodiscard]] Result<double> number(const toml::node& node, std::string_view what) const {
    const auto value = node.value<double>();
    if (!value || !node.is_number())
      return fail(ErrorCode::malformed, fmt::format("{} is not a number", what), place(where_, node));
    return *value;
  }

  Result<void> read_head(const toml::table& file) {
    MIEN_TRY_ASSIGN(const std::string name, text(file.get("name"), "name"));
    std::vector<std::string> known;
    for (const NamedShapes& shapes : kOutsideShapes) {
      if (shapes.profile == name) table_.names = &shapes;
      known.emplace_back(shapes.profile);
    }
    if (table_.names == nullptr)
      return fail(ErrorCode::malformed,
                  fmt::format("there is no profile '{}'{}", excerpt(name), did_you_mean(name, known)),
                  place(where_, *file.get("name")), "mien/face/profile_names.h names their shapes");
    shape_names_ = strings(table_.names->shapes);
    table_.rows.resize(shape_names_.size());
    MIEN_TRY_ASSIGN(table_.title, text(file.get("title"), "title"));
    MIEN_TRY_ASSIGN(table_.source, text(file.get("source"), "source"));
    if (const toml::node* const extends = file.get("extends")) return extend(*extends);
    return {};
  }

  /// The rows of an earlier profile whose shapes this one has too.
  Result<void> extend(const toml::node& node) {
    MIEN_TRY_ASSIGN(const std::string name, text(&node, "extends"));
    const auto base = std::ranges::find_if(
        earlier_, [&](const ProfileTable& table) { return table.names->profile == name; });
    if (base == earlier_.end())
      return fail(ErrorCode::malformed, fmt::format("no profile '{}' was read before", excerpt(name)),
                  place(where_, node));
    for (std::size_t i = 0; i < base->rows.size(); ++i) {
      MIEN_TRY_ASSIGN(const std::size_t shape,
                      find(base->names->shapes[i], shape_names_, table_.names->profile, node));
      table_.rows[shape] = base->rows[i];
    }
    return {};
  }

  [[nodiscard]] Result<std::size_t> find(std::string_view name, const std::vector<std::string>& names,
                                         std::string_view whose, const toml::node& node) const {
    const auto found = std::ranges::find(names, name);
    if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
    return fail(ErrorCode::malformed,
                fmt::format("{} has no shape '{}'{}", whose, excerpt(name), did_you_mean(name, names)),
                place(where_, node));
  }

  /// Of `lacks` the keys are inner shapes, of the others the profile's.
  Result<void> each(const toml::table& file, std::string_view key,
                    Result<void> (Reader::*read_entry)(std::size_t shape, const toml::node& node)) {
    const toml::node* const node = file.get(key);
    if (node == nullptr) return {};
    const toml::table* const table = node->as_table();
    if (table == nullptr)
      return fail(ErrorCode::malformed, fmt::format("'{}' is no table", key), place(where_, *node));
    const bool inner = key == "lacks";
    for (const auto& [name, value] : *table) {
      MIEN_TRY_ASSIGN(const std::size_t shape,
                      find(name.str(), inner ? inner_names() : shape_names_,
                           inner ? "the inner profile" : table_.names->profile, value));
      MIEN_TRY((this->*read_entry)(shape, value));
    }
    return {};
  }

  [[nodiscard]] bool is_told(std::size_t shape) const {
    return !table_.rows[shape].gains.empty() || !table_.rows[shape].reason.empty();
  }
  [[nodiscard]] std::unexpected<Error> twice(std::string_view name, const toml::node& node) const {
    return fail(ErrorCode::malformed, fmt::format("'{}' is told of twice", name), place(where_, node));
  }

  Result<void> read_gains(std::size_t shape, const toml::node& node) {
    const std::string& name = shape_names_[shape];
    if (is_told(shape)) return twice(name, node);
    const toml::table* const gains = node.as_table();
    if (gains == nullptr || gains->empty())
      return fail(ErrorCode::malformed, fmt::format("'{}' has no gain", name), place(where_, node),
                  "write { jawOpen = 1 }, or a reason in [none]");
    for (const auto& [inner, value] : *gains) {
      MIEN_TRY_ASSIGN(const std::size_t k, find(inner.str(), inner_names(), "the inner profile", value));
      const std::string what = fmt::format("the gain of '{}' in '{}'", inner.str(), name);
      MIEN_TRY_ASSIGN(const double gain, number(value, what));
      const float factor = static_cast<float>(gain);
      if (!std::isfinite(factor) || !(factor > 0))
        return fail(ErrorCode::out_of_range, fmt::format("{} is {:g}", what, gain), place(where_, value),
                    "gains are finite and above 0");
      table_.rows[shape].gains.push_back({static_cast<std::uint16_t>(k), factor});
    }
    std::ranges::sort(table_.rows[shape].gains, {}, &ProfileTerm::column);
    return {};
  }

  Result<void> read_none(std::size_t shape, const toml::node& node) {
    if (is_told(shape)) return twice(shape_names_[shape], node);
    MIEN_TRY_ASSIGN(table_.rows[shape].reason, text(&node, shape_names_[shape]));
    return {};
  }

  Result<void> read_share(std::size_t shape, const toml::node& node) {
    const std::string what = fmt::format("the share of '{}'", shape_names_[shape]);
    MIEN_TRY_ASSIGN(const double share, number(node, what));
    if (!(share >= 0 && share <= 1))
      return fail(ErrorCode::out_of_range, fmt::format("{} is {:g}", what, share), place(where_, node),
                  "shares go from 0 to 1");
    ProfileRow& row = table_.rows[shape];
    if (row.gains.empty())
      return fail(ErrorCode::malformed, fmt::format("'{}' has a share but no gain", shape_names_[shape]),
                  place(where_, node));
    row.share = share;
    return {};
  }

  Result<void> read_lack(std::size_t inner, const toml::node& node) {
    if (!tellers(inner).empty()) return twice(inner_name(inner), node);
    MIEN_TRY_ASSIGN(table_.lacks[inner], text(&node, inner_name(inner)));
    return {};
  }

  /// The shapes that an inner one became.
  [[nodiscard]] std::vector<std::size_t> tellers(std::size_t inner) const {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < table_.rows.size(); ++i)
      for (const ProfileTerm& gain : table_.rows[i].gains)
        if (gain.column == inner) out.push_back(i);
    return out;
  }

  [[nodiscard]] Result<void> check_all_are_told() const {
    for (std::size_t i = 0; i < table_.rows.size(); ++i)
      if (!is_told(i))
        return fail(ErrorCode::malformed, fmt::format("'{}' is missing", shape_names_[i]), where_,
                    "write its gains in [map], or in [none] why it has no counterpart");
    for (std::size_t k = 0; k < kInnerCount; ++k)
      if (tellers(k).empty() && table_.lacks[k].empty())
        return fail(ErrorCode::malformed, fmt::format("nothing tells the inner shape '{}'", inner_name(k)),
                    where_, "write in [lacks] why");
    return {};
  }

  [[nodiscard]] Result<void> check_shares() const {
    for (std::size_t k = 0; k < kInnerCount; ++k) {
      double sum = 0;
      std::size_t told = 0;
      const std::vector<std::size_t> shapes = tellers(k);
      for (const std::size_t i : shapes) {
        sum += table_.rows[i].share.value_or(0);
        told += table_.rows[i].share ? 1U : 0U;
      }
      if (told != 0 && (told != shapes.size() || std::abs(sum - 1) > kShareTolerance))
        return fail(ErrorCode::out_of_range,
                    fmt::format("the shares of '{}' sum to {:g} in {} of {} shapes", inner_name(k), sum, told,
                                shapes.size()),
                    where_, "give all of them one, and 1 together");
    }
    return {};
  }

  const std::string& where_;
  std::span<const ProfileTable> earlier_;
  ProfileTable table_;
  std::vector<std::string> shape_names_;
};

}  // namespace

Result<ProfileTable> parse_profile(std::string_view toml, const std::string& where,
                                   std::span<const ProfileTable> earlier) {
  MIEN_TRY_ASSIGN(const toml::table file, parse_toml(toml, where));
  return Reader(where, earlier).read(file);
}

SparseRowsData outward_rows(const ProfileTable& table) {
  SparseRowsData out;
  for (const ProfileRow& row : table.rows) {
    for (const ProfileTerm& gain : row.gains)
      out.terms.push_back({gain.column, gain.factor / static_cast<float>(row.gains.size())});
    out.first.push_back(static_cast<std::uint16_t>(out.terms.size()));
  }
  return out;
}

SparseRowsData inward_rows(const ProfileTable& table) {
  std::array<std::vector<std::pair<std::size_t, float>>, kInnerCount> gains;
  for (std::size_t i = 0; i < table.rows.size(); ++i)
    for (const ProfileTerm& gain : table.rows[i].gains) gains[gain.column].emplace_back(i, gain.factor);
  SparseRowsData out;
  for (const auto& shapes : gains) {
    for (const auto& [shape, gain] : shapes) {
      const double share = table.rows[shape].share.value_or(1.0 / static_cast<double>(shapes.size()));
      if (share > 0)
        out.terms.push_back({static_cast<std::uint16_t>(shape), static_cast<float>(share / double{gain})});
    }
    out.first.push_back(static_cast<std::uint16_t>(out.terms.size()));
  }
  return out;
}

}  // namespace mien::face
