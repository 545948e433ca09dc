#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>

#include "mien/core/excerpt.h"
#include "mien/core/files.h"
#include "mien/core/nearest_word.h"
#include "mien/core/random.h"
#include "mien/core/toml.h"
#include "mien/face/rig_constraints.h"

namespace mien::face {

/// rigs/constraints/ict.toml, which the build writes into a source.
extern const std::string_view kNaturalConstraintsToml;

namespace {

constexpr std::size_t kMostPoints = 64;
/// By which rules are held to settle, and where they are drawn from: no run of chance, or a file would load
/// today and not tomorrow.
constexpr int kRandomFaces = 1000;
constexpr std::uint64_t kSeed = 20260107;

/// What a rule is for.
struct Uses {
  bool live = true, solve = true, always = false;
};

/// A rule, what it is for, and the line on which it stands.
template <class Rule>
struct Told {
  Rule rule;
  Uses uses;
  std::uint32_t line = 0;
};

class ConstraintsReader {
 public:
  explicit ConstraintsReader(const std::string& where) : where_(where) {}

  Result<void> read(const toml::table& file) {
    MIEN_TRY(only_keys(file, {"name", "exclusive", "together", "conditional"}, where_));
    std::size_t count = 0;
    const toml::node* beyond = nullptr;  // The first rule that is one too many.
    for (const char* kind : {"exclusive", "together", "conditional"})
      if (const toml::node* node = file.get(kind)) {
        const toml::array* rules = node->as_array();
        if (rules == nullptr)
          return fail(ErrorCode::malformed, fmt::format("'{}' is no list of rules", kind),
                      place(where_, *node), fmt::format("begin each with [[{}]]", kind));
        if (beyond == nullptr && count + rules->size() > RigConstraints::kMostRules)
          beyond = &(*rules)[RigConstraints::kMostRules - count];
        count += rules->size();
      }
    if (beyond != nullptr)
      return fail(ErrorCode::out_of_range,
                  fmt::format("{} rules are more than {}", count, RigConstraints::kMostRules),
                  place(where_, *beyond), "leave out those that others imply");
    MIEN_TRY(each(file, "exclusive", [&](const toml::table& rule) { return read_exclusive(rule); }));
    MIEN_TRY(each(file, "together", [&](const toml::table& rule) { return read_together(rule); }));
    return each(file, "conditional", [&](const toml::table& rule) { return read_conditional(rule); });
  }

  /// Conditions so that what one goes by comes before it; refuses a circle of them.
  Result<void> sort_conditions() {
    std::vector<Told<Condition>> sorted;
    // 0 not looked at, 1 being looked at, 2 done.
    std::vector<int> state(conditions.size(), 0);
    // By stack instead of by recursion: a file may have a chain of 512.
    for (std::size_t first = 0; first < conditions.size(); ++first) {
      std::vector<std::size_t> stack = {first};
      while (!stack.empty()) {
        const std::size_t i = stack.back();
        if (state[i] == 2) {
          stack.pop_back();
          continue;
        }
        state[i] = 1;
        bool waits = false;
        for (std::size_t k = 0; k < conditions.size(); ++k) {
          if (conditions[k].rule.a != conditions[i].rule.b || state[k] == 2) continue;
          if (state[k] == 1)
            return fail(ErrorCode::malformed,
                        fmt::format("'{}' is bounded by itself, over '{}'", kShapeNames[conditions[i].rule.a],
                                    kShapeNames[conditions[i].rule.b]),
                        line(conditions[i].line), "take one of these conditions out");
          stack.push_back(k);
          waits = true;
        }
        if (waits) continue;
        state[i] = 2;
        sorted.push_back(conditions[i]);
        stack.pop_back();
      }
    }
    conditions = std::move(sorted);
    return {};
  }

  [[nodiscard]] std::string line(std::uint32_t number) const {
    return number == 0 ? where_ : fmt::format("{}, line {}", where_, number);
  }

  std::vector<Told<ExclusivePair>> exclusive;
  std::vector<Told<TogetherGroup>> together;
  std::vector<Told<Condition>> conditions;

 private:
  template <class Read>
  Result<void> each(const toml::table& file, const char* kind, Read read) {
    const toml::node* node = file.get(kind);
    if (node == nullptr) return {};
    for (const toml::node& entry : *node->as_array()) {
      const toml::table* rule = entry.as_table();
      if (rule == nullptr)
        return fail(ErrorCode::malformed, fmt::format("a rule of '{}' is no table", kind),
                    place(where_, entry), fmt::format("begin each with [[{}]]", kind));
      MIEN_TRY(read(*rule));
    }
    return {};
  }

  Result<std::size_t> shape_of(const toml::node* node, const char* key, const toml::table& rule) const {
    const auto name = node == nullptr ? std::nullopt : node->value_exact<std::string>();
    if (!name)
      return fail(ErrorCode::malformed, fmt::format("'{}' is missing, or names no shape", key),
                  place(where_, node == nullptr ? static_cast<const toml::node&>(rule) : *node),
                  R"(write a shape's name, as "jawOpen")");
    const std::size_t i = shape_index(*name);
    if (i == kShapeCount) {
      const std::vector<std::string> known(kShapeNames.begin(), kShapeNames.end());
      return fail(ErrorCode::malformed,
                  fmt::format("no shape is called '{}'{}", excerpt(*name), did_you_mean(*name, known)),
                  place(where_, *node), "names are those of the 53, as eyeBlink_L");
    }
    return i;
  }

  Result<std::pair<std::size_t, std::size_t>> two_shapes(const toml::table& rule) const {
    MIEN_TRY_ASSIGN(const std::size_t a, shape_of(rule.get("a"), "a", rule));
    MIEN_TRY_ASSIGN(const std::size_t b, shape_of(rule.get("b"), "b", rule));
    if (a == b)
      return fail(ErrorCode::malformed, fmt::format("'{}' stands twice in a rule", kShapeNames[a]),
                  place(where_, *rule.get("b")), "a rule is between two shapes");
    return std::pair(a, b);
  }

  Result<double> weight_of(const toml::node& node, std::string_view what) const {
    const auto number = node.is_number() ? node.value<double>() : std::nullopt;
    if (!number)
      return fail(ErrorCode::malformed, fmt::format("{} is not a number", what), place(where_, node));
    if (!(*number >= 0 && *number <= 1))
      return fail(ErrorCode::out_of_range, fmt::format("{} is {}", what, *number), place(where_, node),
                  "give 0 to 1");
    return *number;
  }

  Result<Uses> uses_of(const toml::table& rule) const {
    Uses uses;
    if (const toml::node* node = rule.get("in")) {
      const toml::array* names = node->as_array();
      const auto no_uses = [&](const toml::node& at) {
        return fail(ErrorCode::malformed, "'in' is no list of uses", place(where_, at),
                    R"(write ["live"], ["solve"], or leave it out for both)");
      };
      if (names == nullptr || names->empty()) return no_uses(*node);
      uses.live = uses.solve = false;
      for (const toml::node& entry : *names) {
        const std::string name = entry.value_or(std::string());
        if (name != "live" && name != "solve") return no_uses(entry);
        (name == "live" ? uses.live : uses.solve) = true;
      }
    }
    if (const toml::node* node = rule.get("always")) {
      const auto always = node->value_exact<bool>();
      if (!always) return fail(ErrorCode::malformed, "'always' is not true or false", place(where_, *node));
      if (*always && !uses.live)
        return fail(ErrorCode::malformed, "a rule that is no live one is not obeyed always",
                    place(where_, *node), R"(leave out 'always', or add "live" to 'in')");
      uses.always = *always;
    }
    return uses;
  }

  Result<void> read_exclusive(const toml::table& rule) {
    MIEN_TRY(only_keys(rule, {"a", "b", "in", "always"}, where_));
    MIEN_TRY_ASSIGN(const auto shapes, two_shapes(rule));
    MIEN_TRY_ASSIGN(const Uses uses, uses_of(rule));
    exclusive.push_back({{shapes.first, shapes.second}, uses, rule.source().begin.line});
    return {};
  }

  Result<void> read_together(const toml::table& rule) {
    MIEN_TRY(only_keys(rule, {"shapes", "within", "in", "always"}, where_));
    const toml::node* node = rule.get("shapes");
    const toml::array* names = node == nullptr ? nullptr : node->as_array();
    if (names == nullptr || names->size() < 2 || names->size() > kShapeCount)
      return fail(ErrorCode::malformed, "'shapes' is no list of two names or more",
                  place(where_, node == nullptr ? static_cast<const toml::node&>(rule) : *node),
                  R"(write shapes = ["eyeBlink_L", "eyeBlink_R"])");
    TogetherGroup group;
    for (const toml::node& name : *names) {
      MIEN_TRY_ASSIGN(const std::size_t i, shape_of(&name, "shapes", rule));
      if (std::ranges::find(group.shapes, i) != group.shapes.end())
        return fail(ErrorCode::malformed, fmt::format("'{}' stands twice in a rule", kShapeNames[i]),
                    place(where_, name), "name each shape once");
      group.shapes.push_back(i);
    }
    if (const toml::node* within = rule.get("within")) {
      MIEN_TRY_ASSIGN(const double band, weight_of(*within, "'within'"));
      group.within = static_cast<float>(band);
    }
    MIEN_TRY_ASSIGN(const Uses uses, uses_of(rule));
    together.push_back({std::move(group), uses, rule.source().begin.line});
    return {};
  }

  Result<void> read_conditional(const toml::table& rule) {
    MIEN_TRY(only_keys(rule, {"a", "b", "at_most", "in", "always"}, where_));
    MIEN_TRY_ASSIGN(const auto shapes, two_shapes(rule));
    const toml::node* node = rule.get("at_most");
    const toml::array* points = node == nullptr ? nullptr : node->as_array();
    const auto no_points = [&](const toml::node& at) {
      return fail(ErrorCode::malformed,
                  fmt::format("'at_most' is no list of 1 to {} points [weight of b, most of a]", kMostPoints),
                  place(where_, at), "write at_most = [[0, 0], [1, 1]]");
    };
    if (points == nullptr || points->empty() || points->size() > kMostPoints)
      return no_points(node == nullptr ? static_cast<const toml::node&>(rule) : *node);
    Condition condition{.a = shapes.first, .b = shapes.second, .at_most = {}};
    for (const toml::node& entry : *points) {
      const toml::array* pair = entry.as_array();
      if (pair == nullptr || pair->size() != 2) return no_points(entry);
      Condition::Point point;
      MIEN_TRY_ASSIGN(point.b, weight_of((*pair)[0], "a weight of b"));
      MIEN_TRY_ASSIGN(point.a, weight_of((*pair)[1], "a most of a"));
      if (!condition.at_most.empty() && !(point.b > condition.at_most.back().b))
        return fail(ErrorCode::malformed, "weights of b do not ascend", place(where_, entry),
                    "sort the points by b");
      condition.at_most.push_back(point);
    }
    MIEN_TRY_ASSIGN(const Uses uses, uses_of(rule));
    conditions.push_back({std::move(condition), uses, rule.source().begin.line});
    return {};
  }

  std::string where_;
};

/// The rules of one use.
RuleSet rules_of(const ConstraintsReader& file, bool Uses::*use) {
  RuleSet rules;
  const auto take = [use](const auto& told, auto& taken) {
    for (const auto& one : told)
      if (one.uses.*use) taken.push_back(one.rule);
  };
  take(file.exclusive, rules.exclusive);
  take(file.together, rules.together);
  take(file.conditions, rules.conditions);
  return rules;
}

/// The line of the first of these rules that is broken; 0: none is.
std::uint32_t broken_line(const ConstraintsReader& file, bool Uses::*use, const BlendshapeWeights& w) {
  std::uint32_t line = 0;
  const auto look = [&](const auto& told) {
    const auto found =
        std::ranges::find_if(told, [&](const auto& one) { return one.uses.*use && !one.rule.obeyed(w); });
    if (line == 0 && found != told.end()) line = found->line;
  };
  look(file.exclusive);
  look(file.together);
  look(file.conditions);
  return line;
}

/// Errors: malformed (a face does not settle).
Result<void> try_faces(const ConstraintsReader& file, bool Uses::*use, const std::string& where) {
  const RuleSet rules = rules_of(file, use);
  Random random(kSeed);
  for (int face = 0; face < kRandomFaces; ++face) {
    BlendshapeWeights weights;
    // Every other face has shapes at their ends too, where rules pull the farthest.
    const double at_ends = face % 2 == 0 ? 0 : 0.5;
    for (float& w : weights.values)
      w = random.chance(at_ends) ? static_cast<float>(random.below(2)) : static_cast<float>(random.uniform());
    if (rules.settles(weights)) continue;
    return fail(ErrorCode::malformed,
                fmt::format("this rule fights with others: after {} passes over all it is still broken",
                            RuleSet::kPasses),
                fmt::format("{}, line {}", where, broken_line(file, use, weights)),
                "widen it, or take out what asks for the opposite");
  }
  return {};
}

}  // namespace

Result<RigConstraints> RigConstraints::parse(std::string_view toml, const std::string& where) {
  if (toml.size() > kMostBytes)
    return fail(ErrorCode::out_of_range, fmt::format("{} bytes are more than {}", toml.size(), kMostBytes),
                where, "512 rules need far less");
  MIEN_TRY_ASSIGN(const toml::table file, parse_toml(toml, where));
  ConstraintsReader reader(where);
  MIEN_TRY(reader.read(file));
  MIEN_TRY(reader.sort_conditions());
  MIEN_TRY(try_faces(reader, &Uses::live, where));
  MIEN_TRY(try_faces(reader, &Uses::always, where));
  RigConstraints out;
  out.live_ = rules_of(reader, &Uses::live);
  out.always_ = rules_of(reader, &Uses::always);
  out.solve_ = rules_of(reader, &Uses::solve);
  if (toml.starts_with("\xEF\xBB\xBF")) toml.remove_prefix(3);  // A byte order mark.
  out.text_ = toml;
  for (char& c : out.text_)
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  return out;
}

Result<RigConstraints> RigConstraints::read(const std::filesystem::path& path) {
  MIEN_TRY_ASSIGN(const std::string text, read_text(path, kMostBytes));
  return parse(text, path.string());
}

const RigConstraints& natural_constraints() {
  // Of a file that the tests hold to be sound.
  static const RigConstraints kNatural =
      RigConstraints::parse(kNaturalConstraintsToml, "rigs/constraints/ict.toml").value();
  return kNatural;
}

}  // namespace mien::face
