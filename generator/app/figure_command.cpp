#include "app/commands.h"

namespace ensonify {

Status figure_command(const FigureOptions& options, bool) { return write_figure(options); }

}  // namespace ensonify
