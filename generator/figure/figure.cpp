#include "figure/figure.h"

namespace ensonify {

Status write_figure(const FigureOptions&) { return Error{ErrorKind::bug, "not written yet"}; }

}  // namespace ensonify
