#include "compare/page_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "compare/comparison_text.h"
#include "formats/bytes.h"
#include "formats/png.h"

namespace ensonify {
namespace {

constexpr double kUnderMedian = 20, kOverMedian = 30;  // dB
constexpr int kMostSide = 360;

// Mean intensities of squares of pixels, so that no side is too long.
std::vector<double> thinned(const GridImage& image, int step, int rows, int columns) {
  std::vector<double> intensity;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      double sum = 0, count = 0;
      for (int i = r * step; i < std::min(image.rows, (r + 1) * step); ++i) {
        for (int j = c * step; j < std::min(image.columns, (c + 1) * step); ++j) {
          const auto a = static_cast<double>(
              image
                  .amplitude[static_cast<std::size_t>(i) * static_cast<std::size_t>(image.columns) +
                             static_cast<std::size_t>(j)]);
          sum += a * a;
          count += 1;
        }
      }
      intensity.push_back(sum / count);
    }
  }
  return intensity;
}

std::vector<ExampleImage> examples_of(const std::vector<GridImage>& images) {
  std::vector<ExampleImage> examples;
  std::vector<std::vector<double>> all;
  std::vector<double> levels;
  for (const GridImage& image : images) {
    const int step = std::max(1, (std::max(image.rows, image.columns) + kMostSide - 1) / kMostSide);
    ExampleImage example;
    example.rows = (image.rows + step - 1) / step;
    example.columns = (image.columns + step - 1) / step;
    all.push_back(thinned(image, step, example.rows, example.columns));
    for (const double v : all.back()) {
      if (v > 0) levels.push_back(10 * std::log10(v));
    }
    examples.push_back(std::move(example));
  }
  double median = 0;
  if (!levels.empty()) {
    const auto middle = levels.begin() + static_cast<std::ptrdiff_t>(levels.size() / 2);
    std::nth_element(levels.begin(), middle, levels.end());
    median = *middle;
  }
  for (std::size_t i = 0; i < examples.size(); ++i) {
    for (const double v : all[i]) {
      const double level = v > 0 ? 10 * std::log10(v) - median : -kUnderMedian;
      const double share = (level + kUnderMedian) / (kUnderMedian + kOverMedian);
      examples[i].pixels.push_back(
          static_cast<std::uint8_t>(std::lround(255 * std::clamp(share, 0.0, 1.0))));
    }
  }
  return examples;
}

std::vector<std::size_t> shown_of(std::size_t count) {
  std::vector<std::size_t> shown;
  for (const std::size_t i : {std::size_t{0}, count / 2, count - 1}) {
    if (count > 0 && std::find(shown.begin(), shown.end(), i) == shown.end()) shown.push_back(i);
  }
  return shown;
}

std::string part_named(std::string_view name) {
  for (const ComparePart& part : compare_parts()) {
    if (name == part.name) return part.text;
  }
  return {};
}

void put(std::string& page, std::string_view mark, const std::string& text) {
  const std::size_t at = page.find(mark);
  ENSONIFY_ASSERT(at != std::string::npos);
  page.replace(at, mark.size(), text);
}

std::string verdict_html(Verdict verdict) {
  return fmt::format("<span class=\"verdict {}\">{}</span>",
                     verdict == Verdict::left_out ? "left" : verdict_word(verdict),
                     verdict_word(verdict));
}

std::string row_html(const std::string& title, const std::string& real,
                     const std::string& simulated, const std::string& difference,
                     const std::string& interval, const std::string& verdict) {
  return fmt::format(
      "<tr><td class=\"title\">{}</td><td class=\"number\">{}</td><td class=\"number\">{}</td>"
      "<td class=\"number\">{}</td><td class=\"number\">{}</td><td>{}</td></tr>\n",
      html_text(title), real, simulated, difference, interval, verdict);
}

std::string interval_html(double low, double high) {
  return fmt::format("{} to {}", short_number(low), short_number(high));
}

std::string statistic_html(const ComparedStatistic& s) {
  const std::string title = s.unit.empty() ? s.title : s.title + ", " + s.unit;
  if (s.verdict == Verdict::left_out) {
    return row_html(title, "", "", "", "", verdict_html(s.verdict) + " " + html_text(s.reason));
  }
  const char* const both = s.is_histogram ? "histogram" : "curve";
  return row_html(title, s.is_curve() ? both : short_number(s.real[0]),
                  s.is_curve() ? both : short_number(s.simulated[0]), short_number(s.difference),
                  interval_html(s.low, s.high), verdict_html(s.verdict));
}

constexpr const char* kTableHead =
    "<table><thead><tr><th></th><th class=\"number\">real</th><th class=\"number\">simulated</th>"
    "<th class=\"number\">difference</th><th class=\"number\">95 % interval</th><th></th></tr>"
    "</thead><tbody>\n";

std::string table_html(const Comparison& comparison) {
  std::string html = kTableHead, group;
  for (const ComparedStatistic& s : comparison.statistics) {
    if (s.group != group) {
      group = s.group;
      html += fmt::format("<tr class=\"group\"><th colspan=\"6\">{}</th></tr>\n", html_text(group));
    }
    html += statistic_html(s);
  }
  return html + "</tbody></table>";
}

std::string classifier_html(const Comparison& comparison) {
  if (!comparison.classifier) return "<p>Left out: too few patches of the ground.</p>";
  const ClassifierResult& result = *comparison.classifier;
  std::string html =
      "<table><thead><tr><th></th><th class=\"number\">AUC</th><th class=\"number\">standard "
      "error</th><th class=\"number\">95 % interval</th><th></th></tr></thead><tbody>\n";
  const auto add = [&](std::string_view title, const Auc& auc) {
    html += fmt::format(
        "<tr><td class=\"title\">{}</td><td class=\"number\">{:.3f}</td><td "
        "class=\"number\">{:.3f}</td><td class=\"number\">{:.3f} to {:.3f}</td><td>{}</td></tr>\n",
        html_text(title), auc.value, auc.error, auc.low, auc.high,
        verdict_html(auc.differs ? Verdict::differs : Verdict::agrees));
  };
  add("all features", result.all);
  const auto names = feature_names();
  for (std::size_t k = 0; k < names.size(); ++k) add(names[k], result.single[k]);
  return html + "</tbody></table>";
}

Result<std::string> images_html(const char* title, const std::vector<ExampleImage>& images) {
  std::string html = fmt::format("<figure><h3>{}</h3><div>", title);
  for (const ExampleImage& image : images) {
    const auto png = encode_png(image.pixels, image.rows, image.columns);
    if (!png) return png.error();
    html += fmt::format(
        "<img alt=\"{} image\" width=\"{}\" height=\"{}\" "
        "src=\"data:image/png;base64,{}\">",
        title, image.columns, image.rows, base64(*png));
  }
  return html + "</div></figure>";
}

std::string curves_html(const Comparison& comparison) {
  const auto figure = [](const std::string& title, const std::string& verdict,
                         const std::string& svg) {
    return svg.empty() ? std::string()
                       : fmt::format("<figure><figcaption>{} {}</figcaption>{}</figure>\n",
                                     html_text(title), verdict, svg);
  };
  std::string html = figure("histogram of the level", "", histogram_svg(comparison));
  for (const ComparedStatistic& s : comparison.statistics) {
    if (s.is_curve() && !s.is_histogram)
      html += figure(s.title, verdict_html(s.verdict), curve_svg(s));
  }
  return html;
}

std::string summary_of(const Comparison& comparison) {
  std::size_t compared = 0, differs = 0;
  for (const ComparedStatistic& s : comparison.statistics) {
    compared += s.verdict != Verdict::left_out;
    differs += s.verdict == Verdict::differs;
  }
  return fmt::format(
      "{} of {} statistics differ; of equal data sets about one in 20 does by chance. Of a curve, "
      "the difference is the weighted rms difference, of a histogram the distance, and the "
      "interval "
      "holds it for 95 % of equal data sets.",
      differs, compared);
}

}  // namespace

std::string html_text(std::string_view text) {
  std::string html;
  for (const char c : text) {
    switch (c) {
      case '&':
        html += "&amp;";
        break;
      case '<':
        html += "&lt;";
        break;
      case '>':
        html += "&gt;";
        break;
      case '"':
        html += "&quot;";
        break;
      default:
        html += c;
    }
  }
  return html;
}

std::vector<ExampleImage> example_pings(const PolarPings& pings) {
  std::vector<GridImage> images;
  for (const std::size_t i : shown_of(pings.amplitude.size())) images.push_back(pings.image(i));
  return examples_of(images);
}

std::vector<ExampleImage> example_crops(const Crops& crops) {
  std::vector<GridImage> images;
  for (const std::size_t i : shown_of(crops.crops.size())) images.push_back(crops.image(i));
  return examples_of(images);
}

Result<std::string> comparison_page(const ComparePage& page) {
  const Comparison& comparison = page.comparison;
  const auto real = images_html("real", page.real_examples);
  if (!real) return real.error();
  const auto simulated = images_html("simulated", page.simulated_examples);
  if (!simulated) return simulated.error();
  const char* const kind = comparison.crops ? "crops" : "pings";
  std::string html = std::string(kComparePageMark) + part_named("page");
  put(html, "@styles@", part_named("style") + part_named("compare"));
  put(html, "@title@", html_text(fmt::format("{} and {}", page.real, page.simulated)));
  put(html, "@facts@",
      fmt::format("<span>real: {} {} in {} blocks</span><span>simulated: {} {} in {} blocks</span>"
                  "<span>mean level, real less simulated: {:.2f} dB</span>",
                  comparison.real_images, kind, comparison.real_blocks, comparison.simulated_images,
                  kind, comparison.simulated_blocks, comparison.gain_db));
  std::string notes;
  for (const std::string& note : comparison.notes) {
    notes += fmt::format("<p class=\"notice\">{}</p>\n", html_text(note));
  }
  put(html, "@summary@", summary_of(comparison));
  put(html, "@table@", table_html(comparison));
  put(html, "@curves@", curves_html(comparison));
  put(html, "@classifier@", classifier_html(comparison));
  put(html, "@images@", "<div class=\"examples\">" + *real + *simulated + "</div>");
  put(html, "@notes@", notes);
  return html;
}

}  // namespace ensonify
