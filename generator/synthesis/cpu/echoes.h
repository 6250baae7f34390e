// From scatterers and volumes to what is deposited.
//
//   series_echoes   a gain e^(-i 2 pi f_c tau) S0, a drawn or its mean
//   power_echoes    S0^2 variance gain^2
#pragma once

#include "synthesis/cpu/node_sums.h"

namespace ensonify {

// Plain arrays of a few hundred scatterers: kernels read nothing else.
struct EchoScratch {
  static constexpr int kCount = 512;
  double delay_s[kCount];
  std::uint32_t key_low[kCount], key_high[kCount];
  float mean_re[kCount], mean_im[kCount], deviation[kCount], gain[kCount];
  float normal_re[kCount], normal_im[kCount];
};

enum class EchoAmplitude { drawn, mean };

void series_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                   const PingTask& task, EchoAmplitude amplitude, Pool<EchoScratch>& pool,
                   const Workers& workers, EchoBuffer& echoes);
void power_echoes(const NodePlan& plan, const Kernels& kernels, const Sonar& sonar,
                  const PingTask& task, Pool<EchoScratch>& pool, const Workers& workers,
                  EchoBuffer& echoes);

}  // namespace ensonify
