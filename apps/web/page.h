#pragma once

namespace gelenk {

class Sandbox;
/// The page's one sandbox; it has begun.
Sandbox& pageSandbox();

}  // namespace gelenk
