#pragma once

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "mien/face/profile.h"
#include "mien/measure/interval.h"
#include "mien/measure/metrics.h"
#include "mien/measure/report.h"

// The rows of a study, as its JSON object, its page and its text have them.
namespace mien::lab {

/// JSON that keeps the order in which it is made.
using Json = nlohmann::ordered_json;

/// One figure of a row.
template <class Row>
struct Column {
  std::string key;   ///< In the JSON object; empty: it is not there.
  std::string head;  ///< In tables.
  /// How tables show it, as fmt has it: "{:.2f}"; empty: it is not there.
  std::string format;
  std::function<Json(const Row&)> value;  ///< null: unknown.
  double factor = 1;                      ///< Tables show a number times this.
};
template <class Row>
using Columns = std::vector<Column<Row>>;

/// A cell: "-" for null, "yes" or "no", words as they are, a number by `format`.
[[nodiscard]] std::string cell_text(const Json& value, const std::string& format, double factor = 1);

/// A row as a JSON object.
template <class Row>
[[nodiscard]] Json json_of(const Row& row, const Columns<Row>& columns) {
  Json out = Json::object();
  for (const Column<Row>& column : columns)
    if (!column.key.empty()) out[column.key] = column.value(row);
  return out;
}

/// Rows as a JSON array of objects.
template <class Row>
[[nodiscard]] Json json_of(const std::vector<Row>& rows, const Columns<Row>& columns) {
  Json out = Json::array();
  for (const Row& row : rows) out.push_back(json_of(row, columns));
  return out;
}

/// The cells of a row.
template <class Row>
[[nodiscard]] std::vector<std::string> cells_of(const Row& row, const Columns<Row>& columns) {
  std::vector<std::string> out;
  for (const Column<Row>& column : columns)
    if (!column.format.empty()) out.push_back(cell_text(column.value(row), column.format, column.factor));
  return out;
}

/// Rows as a table.
template <class Row>
[[nodiscard]] measure::Table table_of(std::string caption, const std::vector<Row>& rows,
                                      const Columns<Row>& columns) {
  measure::Table out{.caption = std::move(caption), .columns = {}, .rows = {}, .strong_rows = {}};
  for (const Column<Row>& column : columns)
    if (!column.format.empty()) out.columns.push_back(column.head);
  for (const Row& row : rows) out.rows.push_back(cells_of(row, columns));
  return out;
}

/// null for what is absent.
template <class Value>
[[nodiscard]] Json or_null(const std::optional<Value>& value) {
  return value ? Json(*value) : Json();
}

/// {"mean", "low", "high"}; the ends null where nothing tells them.
[[nodiscard]] inline Json interval_json(const measure::Interval& of) {
  const auto end = [&](double value) { return of.half() > 0 ? Json(value) : Json(); };
  return {{"mean", of.mean}, {"low", end(of.low)}, {"high", end(of.high)}};
}

/// The mean of a figure that a face may lack.
[[nodiscard]] inline std::optional<double> optional_mean(const std::optional<measure::MeanStd>& value) {
  return value ? std::optional(value->mean) : std::nullopt;
}

/// An object with a value for each shape, by its name. `value` takes the shape's index.
template <class Value>
[[nodiscard]] Json by_shape(const Value& value) {
  Json out = Json::object();
  for (std::size_t k = 0; k < face::kShapeCount; ++k) out[std::string(face::kShapeNames[k])] = value(k);
  return out;
}

}  // namespace mien::lab
