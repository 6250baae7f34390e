#include "app/commands.h"

namespace ensonify {

Status preview(const PreviewOptions&) { return Error{ErrorKind::bug, "not written yet"}; }

}  // namespace ensonify
