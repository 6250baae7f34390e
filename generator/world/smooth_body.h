// Meshes whose material has a specular echo.
//
//   smooth_body    makes them as smooth as their phase needs, or warns of their facets
//   smoothness_hz  the frequency of that phase
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "core/error.h"
#include "scenario/scenario.h"
#include "world/world.h"

namespace ensonify {

// The highest frequency of all sonars of the scenario, so that all instruments of a rig hear the
// same bodies; none if no mesh has a specular echo.
std::optional<double> smoothness_hz(const Scenario& scenario);

// With `normals: smooth`, replaces the mesh of the object by a curved_mesh() for that
// frequency if the object, a part of it or what grows on it has a specular echo. With face normals,
// adds a warning if the mesh stands for a curved body and its facets are too large. `key` names the
// mesh in the library. Errors: those of curved_mesh().
Status smooth_body(const Scenario& scenario, const ObjectSpec& spec, const std::string& key,
                   MeshLibrary& library, MeshShape& shape, std::vector<std::string>& warnings);

}  // namespace ensonify
