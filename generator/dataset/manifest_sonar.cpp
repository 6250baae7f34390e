#include <algorithm>
#include <cmath>

#include "core/part_keys.h"
#include "core/units.h"
#include "dataset/manifest_members.h"
#include "dataset/member_schema.h"

namespace ensonify {

static const char* name_of(Normalization value) {
  return value == Normalization::calibrated ? "calibrated" : "mean_square";
}

namespace {

constexpr const char* kBeamOrder =
    "beam 0 to starboard (most negative azimuth), azimuth grows to port";

template <class Io, class Value>
void pulse_members(Io& io, Value& pulse) {
  io.word("shape", pulse.shape, PulseShape::table);
  if (pulse.shape == PulseShape::lfm || pulse.shape == PulseShape::cw) {
    io("duration_s", pulse.duration_s);
  }
  if (pulse.shape == PulseShape::lfm) io("taper", pulse.taper);
  if (pulse.shape == PulseShape::table) io("rows", pulse.table);
}

template <class Io, class Value>
void side_lobe_members(Io& io, Value& shading) {
  if (shading.kind == Shading::taylor || shading.kind == Shading::chebyshev) {
    io("side_lobe_db", shading.side_lobe_db);
  }
  if (shading.kind == Shading::taylor) io("nbar", shading.nbar);
}

template <class Io, class Info>
void beam_members(Io& io, Info& info) {
  auto& sonar = info.sonar;
  io("count", sonar.beam_count);
  io("spacing_rad", sonar.beam_spacing_rad);
  io("width_rad", sonar.beam_width_rad);
  io.sometimes(!sonar.azimuth_rad.empty(), "azimuth_rad", sonar.azimuth_rad);
  io.sometimes(!sonar.width_rad.empty(), "widths_rad", sonar.width_rad);
  io.group("shading", [&](Io& shading) {
    shading.word("kind", sonar.shading.kind, Shading::chebyshev);
    shading("aperture_wavelengths", info.receive_aperture_wavelengths);
    side_lobe_members(shading, sonar.shading);
  });
  io.null_if(!(sonar.transmit_width_rad > 0), "transmit_width_rad", sonar.transmit_width_rad);
  io.said("first_azimuth_rad", beam_azimuth_rad(sonar, 0));
  io.said("order", kBeamOrder);
}

template <class Io, class Value>
void response_members(Io& io, Value& responses) {
  std::vector<double> re, im;
  for (const std::complex<double>& response : responses) {
    re.push_back(response.real());
    im.push_back(response.imag());
  }
  io("response_re", re);
  io("response_im", im);
  if constexpr (Io::kReads) {
    for (std::size_t i = 0; i < std::min(re.size(), im.size()); ++i) {
      responses.emplace_back(re[i], im[i]);
    }
  }
}

template <class Io, class Info, class Value>
void receiver_members(Io& io, Info& info, Value& array) {
  io.said("mode", "array");
  io("elements", array.elements);
  io("spacing_m", array.spacing_m);
  io("element_width_m", array.element_width_m);
  io.group("shading", [&](Io& shading) {
    shading.word("kind", array.shading.kind, Shading::chebyshev);
    side_lobe_members(shading, array.shading);
  });
  io.word("focus", array.focus, Focus::dynamic);
  io.word("steering", array.steering, Steering::phase);
  io("y_m", info.element_y_m);
  io("weight", info.element_weight);
  response_members(io, array.response);
}

// What a log says of its instrument.
template <class Io, class Value>
void recorded_members(Io& io, Value& sonar) {
  io("frequency_hz", sonar.frequency_hz);
  io("range_min_m", sonar.range_min_m);
  io("range_max_m", sonar.range_max_m);
  io.group("beams", [&](Io& beams) {
    beams("count", sonar.beam_count);
    beams("spacing_rad", sonar.beam_spacing_rad);
    beams.said("first_azimuth_rad", beam_azimuth_rad(sonar, 0));
    beams.said("order", kBeamOrder);
    beams("azimuth_rad", sonar.azimuth_rad);
  });
}

template <class Io, class Value>
void front_end_members(Io& io, Value& front) {
  response_members(io, front.beam_response);
  io.sometimes(front.ping_gain_error_db > 0, "ping_gain_error_db", front.ping_gain_error_db);
  front_end_keys(io, front, [](Io& g, auto& other) { g("azimuth_rad", other.azimuth_rad); });
}

template <class Io, class Value>
void transmit_members(Io& io, const Sonar& sonar, Value& groups) {
  io("groups", groups.count);
  io.sometimes(!groups.sector_beams.empty(), "sector_beams", groups.sector_beams);
  io.sometimes(!groups.frequency_hz.empty(), "frequency_hz", groups.frequency_hz);
  io("order", groups.order);
  io("interval_s", groups.interval_s);
  io.null_if(!(groups.width_rad > 0), "width_rad", groups.width_rad);
  io.sometimes(!groups.level_db.empty(), "level_db", groups.level_db);
  io("level_error_db", groups.level_error_db);
  std::vector<double> after_s;
  if constexpr (Io::kWrites) {
    for (int group = 0; group < groups.count; ++group) {
      after_s.push_back(fired_after_s(sonar, group));
    }
  }
  io("after_s", after_s);
}

}  // namespace

template <class Io, class Value>
void recorder_members(Io& io, Value& recorder) {
  count_keys(io, recorder);
  gamma_key(io, recorder);
  tvg_keys(io, recorder);
  io.optional("range_gain", recorder.range_gain,
              [](Io& g, auto& gain) { range_gain_keys(g, gain); });
  row_gain_key(io, recorder);
}

template <class Io, class Info>
void sonar_members(Io& io, Info& info) {
  auto& sonar = info.sonar;
  if (info.recording) return recorded_members(io, sonar);
  io("frequency_hz", sonar.frequency_hz);
  io("bandwidth_hz", sonar.bandwidth_hz);
  io.group("pulse", [&](Io& pulse) { pulse_members(pulse, sonar.pulse); });
  io.word("window", sonar.window, Window::blackman);
  io("processing_gain", info.processing_gain);
  io("source_level_db", sonar.source_level_db);
  io.said("source_pressure_pa_m", source_pressure_pa_m(sonar));
  io("range_min_m", sonar.range_min_m);
  io("range_max_m", sonar.range_max_m);
  io.group("beams", [&](Io& beams) { beam_members(beams, info); });
  io.group("elevation", [&](Io& elevation) {
    elevation("width_rad", sonar.elevation_width_rad);
    auto& line = sonar.elevation_line;
    elevation.group("shading", [&](Io& shading) {
      shading.word("kind", line.shading.kind, Shading::chebyshev);
      shading("aperture_wavelengths", line.aperture);
      side_lobe_members(shading, line.shading);
    });
    elevation("fan_rad", sonar.elevation_fan_rad);
  });
  io.group("rays", [&](Io& rays) {
    rays("elevation", sonar.rays_elevation);
    rays("azimuth", sonar.rays_azimuth);
    rays("per_cell", sonar.rays_per_cell);
  });
  io.optional("adc", sonar.adc, [](Io& converter, auto& adc) {
    converter("bits", adc.bits);
    converter("full_scale_db", adc.full_scale_db);
    const double full_scale_pa = std::sqrt(mean_square_pa2(adc.full_scale_db));
    converter.said("step_pa", std::ldexp(full_scale_pa, 1 - adc.bits));
  });
  io.word("normalization", sonar.normalization, Normalization::mean_square);
  io.maybe("receiver", sonar.array,
           [&](Io& receiver, auto& array) { receiver_members(receiver, info, array); });
  io.maybe("transmit", sonar.transmit,
           [&](Io& transmit, auto& groups) { transmit_members(transmit, sonar, groups); });
  io.maybe("electronics", sonar.front_end,
           [](Io& electronics, auto& front) { front_end_members(electronics, front); });
  io.maybe("detector", sonar.detector,
           [](Io& part, auto& detector) { detector_keys(part, detector); });
}

template void sonar_members(MemberWriter&, const SequenceInfo&);
template void sonar_members(MemberReader&, SequenceInfo&);
template void sonar_members(MemberSchema&, SequenceInfo&);
template void recorder_members(MemberWriter&, const Recorder&);
template void recorder_members(MemberReader&, Recorder&);
template void recorder_members(MemberSchema&, Recorder&);

}  // namespace ensonify
