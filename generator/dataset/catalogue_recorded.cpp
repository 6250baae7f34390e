#include "dataset/catalogue.h"
#include "dataset/layout.h"

namespace ensonify {
namespace {

using Cells = CatalogueRow::Cells;

CatalogueRow counts_row(const char* file, const char* array, const char* type) {
  return {.file = file,
          .array = array,
          .codec = FileCodec::png,
          .grid = FileGrid::polar,
          .type = type,
          .maker = "`sonar.recorder`"};
}

}  // namespace

std::vector<CatalogueRow> recorded_rows() {
  CatalogueRow bytes = counts_row(layout::kRecorded8, "recorded_8bit.npy", kNpyUint8);
  bytes.file_bytes = 0.7;
  bytes.wanted = [](const FileSelection& s) { return s.recorded_bits == 8; };
  bytes.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.counts_8); };
  bytes.card =
      "| `recorded/PPPPPP_8bit.png` | the counts that the instrument stores, rows samples, columns "
      "beams; `recorder` in `sequence.json` has their scale |";
  bytes.packed_card =
      "| `recorded_8bit.npy` | uint8 [pings, samples, beams], the counts that the instrument "
      "stores; `recorder` in `sequence.json` has their scale |";

  CatalogueRow words = counts_row(layout::kRecorded16, "recorded_16bit.npy", kNpyUint16);
  words.file_bytes = 1.6;
  words.wanted = [](const FileSelection& s) { return s.recorded_bits == 16; };
  words.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.counts_16); };
  words.card =
      "| `recorded/PPPPPP_16bit.png` | the counts that the instrument stores, rows samples, "
      "columns beams; `recorder` in `sequence.json` has their scale |";
  words.packed_card =
      "| `recorded_16bit.npy` | uint16 [pings, samples, beams], the counts that the instrument "
      "stores; `recorder` in `sequence.json` has their scale |";

  CatalogueRow gains{.file = layout::kRecordedRowGain,
                     .array = "recorded_row_gain.npy",
                     .codec = FileCodec::npy,
                     .grid = FileGrid::samples,
                     .type = kNpyFloat32,
                     .file_bytes = 4,
                     .maker = "`sonar.recorder.row_gain_db`"};
  gains.wanted = [](const FileSelection& s) { return s.recorded_bits > 0 && s.row_gains; };
  gains.cells = [](const PingResult& r) -> Cells { return std::span(r.recorded.row_gain); };
  gains.card =
      "| `recorded/PPPPPP_row_gain.npy` | float32 [samples], the gain of each row of counts; "
      "amplitudes are divided by its root |";
  gains.packed_card =
      "| `recorded_row_gain.npy` | float32 [pings, samples], the gain of each row of counts; "
      "amplitudes are divided by its root |";
  return {bytes, words, gains};
}

}  // namespace ensonify
