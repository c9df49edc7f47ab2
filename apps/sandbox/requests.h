#pragma once

#include <optional>
#include <string>

#include "apps/document/json_entry.h"

namespace gelenk {

class Sandbox;

// What a program may ask of the sandbox (docs/sandbox.md, "Driven by a program"), by whichever way its
// messages come: the pipe of --remote, or the messages between a page and the frame in it.

inline constexpr int messageVersion = 1;
inline constexpr const char* requestNames = "get, set, status, scene, open, say";

/// Its "do". Throws std::invalid_argument for what is no request of this version.
std::string checkedRequest(const Json& request);
/// The reply, without "ok"; nullopt: none of requestNames. Throws what says why it cannot be.
std::optional<Json> answerRequest(Sandbox& sandbox, const std::string& what, const Json& request);
/// The pose and what it does, as events tell it.
Json poseMessage(const Sandbox& sandbox);

}  // namespace gelenk
