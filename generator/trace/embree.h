// Embree 3 or 4: the few calls that changed between them.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace ensonify {

#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
inline void init_context(EmbreeContext& context) { rtcInitRayQueryContext(&context); }
inline void intersect_one(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context;
  rtcIntersect1(scene, &ray, &arguments);
}
#else
using EmbreeContext = RTCIntersectContext;
inline void init_context(EmbreeContext& context) { rtcInitIntersectContext(&context); }
inline void intersect_one(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}
#endif

}  // namespace ensonify
