// Everyday things as triangle meshes: what perception is trained to find on the bottom.
//
//   model_mesh     kind and size -> mesh
//   ..._solid      one of each kind, in proportions of its own        bottle.cpp, chain.cpp, ...
//
// What all of them keep: every part is closed (an edge belongs to two triangles, which run along it
// in opposite directions) and its faces look outwards; parts may reach into each other.
#pragma once

#include "scenario/model_spec.h"
#include "world/mesh.h"
#include "world/models/blocks.h"

namespace ensonify {

// As it lies or stands on the bottom z = 0: its lowest point at z = 0, the origin under the middle
// of the box around it, the longest edge of that box `size_m` along x, y or z.
Mesh model_mesh(ModelKind kind, double size_m);

// In any unit and place; the way up is that of model_mesh.
Solid bottle_solid();     // lies, axis x
Solid can_solid();        // lies, axis x
Solid tyre_solid();       // lies flat, axis z
Solid chain_solid();      // lies in a bend along x
Solid hook_solid();       // lies flat, eye towards x
Solid propeller_solid();  // lies flat, axis z
Solid valve_solid();      // stands, pipe along x, wheel on top
Solid carton_solid();     // lies on its largest face
Solid shackle_solid();    // lies flat, bow towards x
Solid wall_solid();       // stands, length along x

}  // namespace ensonify
