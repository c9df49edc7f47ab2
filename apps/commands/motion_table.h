#pragma once

#include <memory>
#include <string>

#include "apps/document/model_reference.h"

namespace gelenk {

class Command;

/// `gelenk fk FILE --amc MOTION --csv`: where every bone of every frame begins and ends.
struct MotionTableRequest {
  Companions files;
  int frame = 0;  ///< from 1; 0: all frames
  std::string unit;
  bool csv = false;

  bool wanted() const {
    return csv || frame != 0 || !files.amc.empty() || !files.asf.empty() || !unit.empty() ||
           !files.clip.empty();
  }
};

/// Adds --amc, --asf, --clip, --frame, --unit, --csv and the files of a body (model_options.h); the request
/// is filled when it is parsed.
std::shared_ptr<MotionTableRequest> addMotionTableOptions(Command& command);

/// Prints `frame,bone,start_x,start_y,start_z,end_x,end_y,end_z` (metres; frames from 1; "rest" without a
/// motion). Bones of an ASF skeleton go from their own start to their own end; of any other model, one row a
/// joint: from the parent's place to its own.
void printMotionTable(const std::string& nameOrFile, const MotionTableRequest& request);

}  // namespace gelenk
