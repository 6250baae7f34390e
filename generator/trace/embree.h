// Wrappers for the few calls that differ between Embree 3 and 4.
//
//   EmbreeContext  init_context
//   intersect_one  intersect_packet   of 4, 8 or 16 rays
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace ensonify {

inline auto intersect_of(const RTCRayHit4&) { return rtcIntersect4; }
inline auto intersect_of(const RTCRayHit8&) { return rtcIntersect8; }
inline auto intersect_of(const RTCRayHit16&) { return rtcIntersect16; }

// The rays of intersect_packet start at one point in similar directions; valid[i] is -1 if lane i
// has a ray, and 0 otherwise.
#if RTC_VERSION_MAJOR >= 4
using EmbreeContext = RTCRayQueryContext;
inline void init_context(EmbreeContext& context) { rtcInitRayQueryContext(&context); }
inline RTCIntersectArguments embree_arguments(EmbreeContext& context, RTCRayQueryFlags flags) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = flags;
  arguments.context = &context;
  return arguments;
}
inline void intersect_one(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  RTCIntersectArguments how = embree_arguments(context, RTC_RAY_QUERY_FLAG_INCOHERENT);
  rtcIntersect1(scene, &ray, &how);
}
template <class RayHits>
void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid, RayHits& rays) {
  RTCIntersectArguments how = embree_arguments(context, RTC_RAY_QUERY_FLAG_COHERENT);
  intersect_of(rays)(valid, scene, &rays, &how);
}
#else
using EmbreeContext = RTCIntersectContext;
inline void init_context(EmbreeContext& context) { rtcInitIntersectContext(&context); }
inline void intersect_one(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}
template <class RayHits>
void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid, RayHits& rays) {
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  intersect_of(rays)(valid, scene, &context, &rays);
}
#endif

}  // namespace ensonify
