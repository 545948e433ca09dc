#include "mien/measure/report.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace mien::measure::report_test {
namespace {

int count(const std::string& text, const std::string& part) {
  int n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++n;
  return n;
}

/// The drawing's first attribute of that name.
std::string attribute(const std::string& drawing, const std::string& name) {
  const std::size_t from = drawing.find(" " + name + "=\"");
  if (from == std::string::npos) return "(none)";
  const std::size_t begin = from + name.size() + 3;
  return drawing.substr(begin, drawing.find('"', begin) - begin);
}

/// What zoom.js makes of the first line's numbers.
std::vector<std::vector<std::pair<double, double>>> carried(const std::string& drawing) {
  const auto two = [&](const char* name) {
    std::istringstream in(attribute(drawing, name));
    std::pair<double, double> out;
    in >> out.first >> out.second;
    return out;
  };
  const auto x = two("data-x"), y = two("data-y"), steps = two("data-steps");
  std::vector<std::vector<std::pair<double, double>>> runs;
  std::istringstream in(attribute(drawing, "data-runs"));
  for (std::string run; std::getline(in, run, ';');) {
    std::istringstream deltas(run);
    double at = 0, value = 0;
    runs.emplace_back();
    for (double dx = 0, dy = 0; deltas >> dx >> dy;) {
      at += dx;
      value += dy;
      runs.back().emplace_back(x.first + at / steps.first * (x.second - x.first),
                               y.first + value / steps.second * (y.second - y.first));
    }
  }
  return runs;
}

Report whole() {
  Report report("A <title> & more", "beneath");
  report.key_figures({{"PVE", "0.75 mm", "ridge 0.89"}});
  report.heading("One");
  report.text("a < b");
  report.table({"Rows", {"name", "value"}, {{"x", "1.5"}, {"y", "2 \xC2\xB1 1"}}, {0}});
  report.plot({"Plot", "t (s)", "y", {{"a", {0, 1, 2}, {0, 1, 0}}, {"b", {0, 1, 2}, {1, 0, 1}}}, {}, {}});
  report.bars({"Bars", "mm", {"a"}, {{"g", {1.0}, {0.5}}}});
  report.image(std::array<std::byte, 3>{std::byte{1}, std::byte{2}, std::byte{3}}, "a \"picture\"");
  return report;
}

TEST(Report, IsWellFormed) {
  const std::string html = whole().html();
  std::vector<std::string> open;
  const std::regex tag("<(/?)([a-z0-9]+)([^>]*)>");
  for (std::sregex_iterator it(html.begin(), html.end(), tag), end; it != end; ++it) {
    const std::string name = (*it)[2], rest = (*it)[3];
    if (name == "meta" || name == "img" || rest.ends_with('/')) continue;
    if ((*it)[1].length() == 0) {
      open.push_back(name);
    } else {
      ASSERT_FALSE(open.empty()) << name;
      EXPECT_EQ(open.back(), name);
      open.pop_back();
    }
  }
  EXPECT_TRUE(open.empty());
}

TEST(Report, NeedsNothingFromOutside) {
  const std::string html = whole().html();
  EXPECT_EQ(count(html, "src=\""), count(html, "src=\"data:"));
  EXPECT_EQ(count(html, "href="), 0);
  EXPECT_EQ(count(html, "url("), 0);
  EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(html.find("data:image/png;base64,AQID"), std::string::npos);
}

TEST(Report, RunsTheOneScriptThatZoomsItsLinePlots) {
  const std::string html = whole().html();
  EXPECT_EQ(count(html, "<script"), 1);
  EXPECT_NE(html.find("<script>\n" + std::string(kZoomScript) + "</script>\n</body>"), std::string::npos);
  // Nothing ends it early, fetches, stores or makes markup of text.
  for (const char* word : {"</", "<!--", "://", "import", "fetch", "XMLHttp", "innerHTML", "insertAdjacent",
                           "eval(", "Function(", "localStorage", "document.write"})
    EXPECT_EQ(kZoomScript.find(word), std::string_view::npos) << word;
  EXPECT_EQ(html, whole().html()) << "the same page twice";

  Report still("no line plot");
  still.bars({"Bars", "mm", {"a"}, {{"g", {1.0}, {}}}});
  EXPECT_EQ(count(still.html(), "<script"), 0);
}

TEST(Report, NoNameEndsADrawingOrTheScript) {
  const std::string name = "\"'></title></svg><script>alert(1)</script><!-- &lt;";
  Report report(name, name);
  report.plot({name, name, name, {{name, {0, 1}, {0, 1}}, {name, {0, 1}, {1, 0}}}, {}, {}});
  const std::string html = report.html();
  EXPECT_EQ(count(html, "<script"), 1);
  EXPECT_EQ(count(html, "</script"), 1);
  EXPECT_EQ(count(html, "<!--"), 0);
  EXPECT_EQ(count(html, "</svg>"), 1);
  EXPECT_NE(html.find("aria-label=\"&quot;'&gt;&lt;/title&gt;"), std::string::npos);
}

TEST(Report, EscapesWhatPeopleWrite) {
  const std::string html = whole().html();
  EXPECT_NE(html.find("<h1>A &lt;title&gt; &amp; more</h1>"), std::string::npos);
  EXPECT_NE(html.find("<p>a &lt; b</p>"), std::string::npos);
  EXPECT_NE(html.find("alt=\"a &quot;picture&quot;\""), std::string::npos);
}

TEST(Report, StandsNumbersToTheRight) {
  const std::string html = whole().html();
  EXPECT_NE(html.find("<td>x</td><td class=\"number\">1.5</td>"), std::string::npos);
  EXPECT_NE(html.find("<tr class=\"strong\"><td>x"), std::string::npos);
}

TEST(Report, IsTheSameInPlainText) {
  EXPECT_EQ(whole().plain_text(),
            "A <title> & more: beneath\n\n"
            "PVE: 0.75 mm (ridge 0.89)\n\n"
            "\nOne\n---\n\n"
            "a < b\n\n"
            "Rows\n\n"
            "name  value\n"
            "x       1.5\n"
            "y     2 \xC2\xB1 1\n\n");
}

TEST(Report, KeepsPlainTextWithinALine) {
  Table table{.caption = "", .columns = {"name"}, .rows = {{"a head"}, {"one"}}, .strong_rows = {}};
  for (int i = 0; i < 4; ++i) {
    table.columns.push_back("column " + std::to_string(i));
    table.rows[1].push_back(std::string(30, static_cast<char>('a' + i)));
  }
  const std::string a(30, 'a'), b(30, 'b'), c(30, 'c'), d(30, 'd');
  EXPECT_EQ(plain_text(table), "name  column 0" + std::string(24, ' ') + "column 1" + std::string(24, ' ') +
                                   "column 2\n" + "a head\none   " + a + "  " + b + "  " + c +
                                   "\n\nname  column 3\na head\none   " + d + "\n");
  Report report("t");
  report.text("word " + std::string(104, 'x') + " y");
  EXPECT_EQ(report.plain_text(), "t\n\nword " + std::string(104, 'x') + "\ny\n\n");
}

TEST(Report, ADashStandsAmongNumbers) {
  Report report("Title", "");
  report.table({.columns = {"name", "change"}, .rows = {{"a set", "+1.2 ± 0.3 %"}, {"none", "–"}}});
  EXPECT_NE(report.html().find("<td class=\"number\">–</td>"), std::string::npos);
}

TEST(AxisTicks, AreRoundAndInside) {
  EXPECT_EQ(axis_ticks(0, 1, 5), (std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1}));
  EXPECT_EQ(axis_ticks(-3, 12, 5), (std::vector<double>{-2, 0, 2, 4, 6, 8, 10, 12}));
  for (const double high : {1e-6, 0.037, 3.0, 17.0, 912.0, 5e7}) {
    const auto ticks = axis_ticks(0, high, 5);
    EXPECT_GE(ticks.size(), 3U) << high;
    EXPECT_LE(ticks.size(), 9U) << high;
    EXPECT_LE(ticks.back(), high * (1 + 1e-9));
  }
  EXPECT_EQ(axis_ticks(2, 2, 5).size(), 1U);
  EXPECT_EQ(axis_ticks(0, std::numeric_limits<double>::quiet_NaN(), 5).size(), 1U);
}

TEST(LinePlot, BreaksWhereThereIsNoNumber) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  const std::string drawing =
      svg(LinePlot{"p", "x", "y", {{"a", {0, 1, 2, 3, 4}, {1, 2, none, 2, 1}}}, {}, {}});
  const std::size_t path = drawing.find(" d=\"");
  const std::string d = drawing.substr(path, drawing.find('"', path + 4) - path);
  EXPECT_EQ(count(d, "M"), 2);
  EXPECT_EQ(count(d, "L"), 2);
  EXPECT_EQ(count(drawing, "nan"), 0);
  const auto runs = carried(drawing);
  ASSERT_EQ(runs.size(), 2U);
  EXPECT_EQ(runs[0].size(), 2U);
  EXPECT_NEAR(runs[1][0].first, 3, 1e-5);
  EXPECT_NEAR(runs[1][0].second, 2, 1e-4);
}

TEST(LinePlot, CarriesItsNumbersFinerThanItDrawsThem) {
  LinePlot plot{"p", "x", "y", {{"a", {}, {}}}, {}, {}};
  for (int i = 0; i < 5'000; ++i) {
    plot.lines[0].x.push_back(-3 + i / 60.0);
    plot.lines[0].y.push_back(std::sin(0.01 * i) - 0.2);
  }
  const std::string drawing = svg(plot);
  EXPECT_EQ(drawing, svg(plot));
  EXPECT_EQ(attribute(drawing, "data-frame"), "66 746 218 10");
  EXPECT_EQ(attribute(drawing, "data-told"), "0 0");
  const auto runs = carried(drawing);
  ASSERT_EQ(runs.size(), 1U);
  ASSERT_EQ(runs[0].size(), 5'000U) << "each point, where the path has some two a pixel";
  EXPECT_LT(count(attribute(drawing, "d"), "L"), 1'500);
  for (std::size_t i = 0; i < runs[0].size(); ++i) {
    ASSERT_NEAR(runs[0][i].first, plot.lines[0].x[i], 1e-4) << i;
    ASSERT_NEAR(runs[0][i].second, plot.lines[0].y[i], 1e-4) << i;
  }
  plot.y_low = -2;
  plot.y_high = 2;
  EXPECT_EQ(attribute(svg(plot), "data-told"), "1 1");
  EXPECT_EQ(attribute(svg(plot), "data-y"), "-2 2");
}

TEST(LinePlot, StaysLightHoweverMuchItIsGiven) {
  LinePlot plot{"p", "x", "y", {}, 0.0, 1.0};
  for (int l = 0; l < 12; ++l) {
    plot.lines.push_back({"a", {}, {}});
    for (int i = 0; i < 20'000; ++i) {
      plot.lines[l].x.push_back(i);
      plot.lines[l].y.push_back(i == 12'345 ? 0.9 : 0.25 + 0.2 * ((i * 7919) % 101) / 101.0);
    }
  }
  const std::string drawing = svg(plot);
  EXPECT_LT(drawing.size(), 600'000U);
  // As many a line as there is room for, and no spike lost.
  const auto runs = carried(drawing);
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_LE(runs[0].size(), 2'002U);
  EXPECT_GT(runs[0].size(), 1'900U);
  double highest = 0;
  for (const auto& [x, y] : runs[0]) highest = std::max(highest, y);
  EXPECT_NEAR(highest, 0.9, 1e-4);
}

TEST(LinePlot, CarriesNumbersFarOutsideTheAxisThatItWasTold) {
  const LinePlot plot{"p", "x", "y", {{"a", {0, 1, 2}, {0.5, 1e300, -1e300}}}, 0.0, 1.0};
  const auto runs = carried(svg(plot));
  ASSERT_EQ(runs.size(), 1U);
  EXPECT_GT(runs[0][1].second, 1e4);
  EXPECT_LT(runs[0][2].second, -1e4);
}

TEST(LinePlot, MarksThePointsOfALineThatAsksForIt) {
  const double none = std::numeric_limits<double>::quiet_NaN();
  LinePlot plot{"p", "x", "y", {{"a", {0, 1, 2}, {1, none, 2}}}, {}, {}};
  EXPECT_EQ(count(svg(plot), "<circle"), 0);
  plot.lines[0].points = true;
  EXPECT_EQ(count(svg(plot), "<circle"), 2) << "where there is a number";
}

TEST(LinePlot, KeepsEverySpikeOfALongCurve) {
  LinePlot plot{"p", "x", "y", {{"a", {}, {}}}, 0.0, 10.0};
  for (int i = 0; i < 100'000; ++i) {
    plot.lines[0].x.push_back(i);
    plot.lines[0].y.push_back(i == 54'321 ? 10 : 0);
  }
  const std::string drawing = svg(plot);
  EXPECT_LT(drawing.size(), 60'000U);
  EXPECT_NE(drawing.find(" 10.0L"), std::string::npos) << "the spike reaches the top of the drawing";
}

TEST(LinePlot, SurvivesHavingNothingToShow) {
  for (const LinePlot& plot : {LinePlot{}, LinePlot{"p", "x", "y", {{"a", {}, {}}}, {}, {}},
                               LinePlot{"p", "x", "y", {{"a", {1}, {1}}}, {}, {}}})
    EXPECT_EQ(count(svg(plot), "nan") + count(svg(plot), "inf"), 0);
  EXPECT_EQ(attribute(svg(LinePlot{"p", "x", "y", {{"a", {}, {}}}, {}, {}}), "data-runs"), "");
}

TEST(BarPlot, LiesDownWhenNamesAreMany) {
  BarPlot plot{"p", "mm", {"a", "b"}, {}};
  for (int i = 0; i < 30; ++i) plot.groups.push_back({"mouthLowerDown_L", {1.0, 2.0}, {}});
  const std::string drawing = svg(plot);
  EXPECT_EQ(count(drawing, "<rect"), 60);
  EXPECT_NE(drawing.find("text-anchor=\"end\">mouthLowerDown_L"), std::string::npos);
  plot.groups.resize(2);
  EXPECT_NE(svg(plot).find("text-anchor=\"middle\">mouthLowerDown_L"), std::string::npos);
}

TEST(BarPlot, LeavesAGapForWhatIsNoNumber) {
  const BarPlot plot{"p", "mm", {"a", "b"}, {{"g", {1.0, std::numeric_limits<double>::infinity()}, {}}}};
  EXPECT_EQ(count(svg(plot), "<rect"), 1);
}

TEST(PlainText, AlignsColumnsAndLetsHeadsRunAcross) {
  const Table table{
      "Who",
      {"", "mm", "what"},
      {{"a head that is longer than any column"}, {"one", "0.5 \xC2\xB1 0.1", "x"}, {"three", "12", "-y"}},
      {0}};
  EXPECT_EQ(plain_text(table),
            "Who\n\n"
            "              mm  what\n"
            "\n"
            "a head that is longer than any column\n"
            "one    0.5 \xC2\xB1 0.1  x\n"
            "three         12  -y\n");
  Report report("t");
  report.table(table);
  EXPECT_NE(report.html().find("<td colspan=\"3\">a head"), std::string::npos);
}

}  // namespace
}  // namespace mien::measure::report_test
