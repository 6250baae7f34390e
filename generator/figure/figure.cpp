#include "figure/figure.h"

#include "dataset/files.h"
#include "dataset/output.h"
#include "figure/animation.h"
#include "figure/frames.h"

namespace ensonify {
namespace {

Result<std::string> encode_still(const FrameMaker& maker, const FigureJob& job) {
  const auto drawing = maker.frame(job.first_ping);
  if (!drawing) return drawing.error();
  if (job.format == FigureFormat::svg) return encode_svg(*drawing);
  const auto image = draw_raster(*drawing);
  return image ? encode_png(*image) : Result<std::string>(image.error());
}

Status animate(const FrameMaker& maker, const FigureJob& job, const FigureOptions& options,
               const std::filesystem::path& path) {
  const AnimationFormat format{maker.layout().width, maker.layout().height, maker.fps()};
  auto sink = job.format == FigureFormat::mp4 ? open_mp4(path, format) : open_webp(path, format);
  if (!sink) return sink.error();
  for (std::uint32_t ping = job.first_ping; ping < job.last_ping; ++ping) {
    if (options.stop != nullptr && options.stop()) {
      return Error{ErrorKind::interrupted, "interrupted; nothing was left behind"};
    }
    const auto drawing = maker.frame(ping);
    if (!drawing) return drawing.error();
    const auto image = draw_raster(*drawing);
    if (!image) return image.error();
    if (const Status added = (*sink)->add(*image); !added) return added;
  }
  return (*sink)->finish();
}

}  // namespace

Result<FigureReport> write_figure(const FigureOptions& options) {
  return without_exceptions("drawing " + options.output.string(), [&]() -> Result<FigureReport> {
    const auto job = choose(options);
    if (!job) return job.error();
    auto place = OutputPlace::open(options.output, false, options.dataset, options.overwrite);
    if (!place) return place.error();
    const auto maker = FrameMaker::open(*job, options);
    if (!maker) return maker.error();
    Status written;
    if (is_animated(job->format)) {
      written = animate(*maker, *job, options, place->temporary());
    } else {
      const auto bytes = encode_still(*maker, *job);
      written = bytes ? write_whole(place->temporary(), *bytes) : Status(bytes.error());
    }
    if (written) written = place->commit();
    if (!written) return written.error();
    return FigureReport{job->last_ping - job->first_ping, maker->limits()};
  });
}

}  // namespace ensonify
