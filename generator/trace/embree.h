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
// Of rays that start at one place and go about the same way; valid[i]: -1, or 0 for no ray.
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit4& rays) {
  RTCIntersectArguments how = embree_arguments(context, RTC_RAY_QUERY_FLAG_COHERENT);
  rtcIntersect4(valid, scene, &rays, &how);
}
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit8& rays) {
  RTCIntersectArguments how = embree_arguments(context, RTC_RAY_QUERY_FLAG_COHERENT);
  rtcIntersect8(valid, scene, &rays, &how);
}
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit16& rays) {
  RTCIntersectArguments how = embree_arguments(context, RTC_RAY_QUERY_FLAG_COHERENT);
  rtcIntersect16(valid, scene, &rays, &how);
}
#else
using EmbreeContext = RTCIntersectContext;
inline void init_context(EmbreeContext& context) { rtcInitIntersectContext(&context); }
inline void intersect_one(RTCScene scene, EmbreeContext& context, RTCRayHit& ray) {
  rtcIntersect1(scene, &context, &ray);
}
// Of rays that start at one place and go about the same way; valid[i]: -1, or 0 for no ray.
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit4& rays) {
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect4(valid, scene, &context, &rays);
}
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit8& rays) {
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, &rays);
}
inline void intersect_packet(RTCScene scene, EmbreeContext& context, const int* valid,
                             RTCRayHit16& rays) {
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect16(valid, scene, &context, &rays);
}
#endif

}  // namespace ensonify
