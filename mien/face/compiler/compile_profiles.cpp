// compile_profiles FOLDER OUT: reads the folder's tables of profiles, one for each that
// mien/face/profile_names.h names, and writes them as C++. What is wrong with one is a line on stderr, and
// exit 2: the build stops there.

#include <fmt/format.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <vector>

#include "mien/core/files.h"
#include "mien/face/compiler/profile_toml.h"

namespace {

using namespace mien::face;
namespace fs = std::filesystem;

constexpr std::size_t kMaxBytes = std::size_t{1} << 20U;

std::string literal(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

/// `constexpr std::array<TYPE, N> NAME = {{...}};`, with N of 0 too.
std::string array_of(std::string_view type, const std::string& name, const std::vector<std::string>& items) {
  std::string out = fmt::format("constexpr std::array<{}, {}> {} = {{", type, items.size(), name);
  for (const std::string& item : items) out += item + ", ";
  return out + "};\n";
}

std::string rows(const std::string& name, const SparseRowsData& data) {
  std::vector<std::string> first, terms;
  for (const std::uint16_t begin : data.first) first.push_back(fmt::format("{}", begin));
  for (const ProfileTerm& term : data.terms)
    terms.push_back(fmt::format("ProfileTerm{{{}, {:#.9g}F}}", term.column, term.factor));
  return array_of("std::uint16_t", name + "_first", first) + array_of("ProfileTerm", name + "_terms", terms);
}

std::string unmatched(const std::string& name, std::span<const std::string> reasons) {
  std::vector<std::string> items;
  for (std::size_t i = 0; i < reasons.size(); ++i)
    if (!reasons[i].empty()) items.push_back(fmt::format("Unmatched{{{}, {}}}", i, literal(reasons[i])));
  return array_of("Unmatched", name, items);
}

std::string code_of(const std::vector<ProfileTable>& tables) {
  std::string arrays, maps;
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const ProfileTable& table = tables[i];
    std::vector<std::string> reasons;
    for (const ProfileRow& row : table.rows) reasons.push_back(row.reason);
    const std::string n(table.names->profile);
    arrays += rows(n + "_outward", outward_rows(table)) + rows(n + "_inward", inward_rows(table)) +
              unmatched(n + "_without", reasons) + unmatched(n + "_lacks", table.lacks);
    maps += fmt::format(
        "    ProfileMap{{{0}, {1}, {2}, kOutsideShapes[{3}].shapes, kOutsideShapes[{3}].groups, "
        "{4}_without,\n"
        "               {4}_lacks, {{{4}_outward_first, {4}_outward_terms}}, {{{4}_inward_first, "
        "{4}_inward_terms}}}},\n",
        literal(n), literal(table.title), literal(table.source), i, n);
  }
  return fmt::format(
      "// Made by compile_profiles of profiles/*.toml.\n"
      "#include \"mien/face/profile_map.h\"\n\n#include <array>\n\n"
      "namespace mien::face {{\nnamespace {{\n\n{}\nconstexpr std::array<ProfileMap, {}> kProfileMaps = "
      "{{\n{}}};\n\n"
      "}}  // namespace\n\n"
      "std::span<const ProfileMap> profile_maps() noexcept {{\n  return kProfileMaps;\n}}\n\n"
      "}}  // namespace mien::face\n",
      arrays, tables.size(), maps);
}

mien::Result<void> compile(const fs::path& folder, const fs::path& out) {
  std::vector<ProfileTable> tables;
  for (const NamedShapes& names : kOutsideShapes) {
    const fs::path path = folder / (std::string(names.profile) + ".toml");
    MIEN_TRY_ASSIGN(const std::string text, mien::read_text(path, kMaxBytes));
    MIEN_TRY_ASSIGN(ProfileTable table, parse_profile(text, path.string(), tables));
    if (table.names != &names)
      return mien::fail(mien::ErrorCode::mismatch,
                        fmt::format("it is the table of {}, not of {}", table.names->profile, names.profile),
                        path.string());
    tables.push_back(std::move(table));
  }
  return mien::write_file(out, code_of(tables));
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "compile_profiles FOLDER OUT\n");
    return 2;
  }
  if (const auto done = compile(argv[1], argv[2]); !done) {
    fmt::print(stderr, "{}\n", done.error().message());
    return 2;
  }
  return 0;
}
