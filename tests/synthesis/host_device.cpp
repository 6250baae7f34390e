// What a HostQueue runs. Test code is not optimized; these loops over echoes, nodes and elements
// are, since tests on a device that is the host would otherwise spend nearly all of their time in
// them, above all under a sanitizer.
#include "synthesis/host_device.h"

namespace ensonify {

template class DeviceBackend<test::HostQueue>;
template class DeviceBackend<test::HostQueue, ArrayProgram<test::HostQueue>>;
template class ArrayProgram<test::HostQueue>;
template class ArrayPowerProgram<test::HostQueue>;

}  // namespace ensonify
