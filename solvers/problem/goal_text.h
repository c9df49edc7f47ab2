#pragma once

#include <memory>
#include <string>
#include <string_view>

#include "solvers/problem/goal_type.h"

namespace gelenk {

/// A goal as typed: its kind and then FIELD=VALUE in any order, separated by blanks, such as
///     distance joint=hand_l other=hand_r length=0.25 role=pin weight=2
/// Joints by name, vectors as X,Y,Z, a rotation as QW,QX,QY,QZ (unit), a polygon as X,Y,Z;X,Y,Z;..., a
/// posture as nq numbers; metres. Fields as in GoalType::fields; those that are optional may be left out, and
/// every kind takes name, weight, role (drag, hold, pin) and priority. masses: of the model, for kinds that
/// need them; may be null. Throws std::invalid_argument that says what is wrong and what there is.
Goal goalFromText(std::string_view text, const Skeleton& skeleton, std::shared_ptr<const Masses> masses = {});

/// The same where the goal will be captured from a pose (GoalType::capture): fields that say where it is,
/// such as target, length or orientation, may be left out.
Goal goalTemplateFromText(std::string_view text, const Skeleton& skeleton,
                          std::shared_ptr<const Masses> masses = {});

/// Axes and directions that are not of unit length to the last bits made so; others stay as they are.
void normaliseDirections(Goal& goal);

/// Whether such a text begins with the name of a kind.
bool namesAKind(std::string_view text);

/// The same in the other direction, numbers exact.
std::string goalToText(const Goal& goal, const Skeleton& skeleton);

/// One line a kind: name, fields (optional ones in brackets) and what it asks for; for help texts.
std::string describeGoalTypes();

const char* toString(Role role);
/// Throws std::invalid_argument that lists the words.
Role parseRole(std::string_view word);

}  // namespace gelenk
