// The page's data as JSON. Private to report/.
//
//   page_json   ready to stand in a <script>: no text of a data set can end it
#pragma once

#include <string>
#include <vector>

#include "report/pictures.h"
#include "report/report.h"
#include "report/statistics_pictures.h"

namespace ensonify {

struct PageContents {
  const StoredDataset& dataset;
  const DatasetFacts& facts;
  const Survey& survey;
  const Look& look;
  const PictureBook& pictures;
  const std::vector<CodedStatistics>& statistics;
  const PreviewOf* preview = nullptr;  // absent: not one
};

std::string page_json(const PageContents& contents);

}  // namespace ensonify
