// Matches by our own matcher, geometric verification by COLMAP's.
#pragma once

#include <filesystem>
#include <vector>

#include "colmap_ext/scene/database.h"
#include "colmap_ext/sfm/colmap_program.h"
#include "colmap_ext/sfm/sparse_update.h"
#include "update_database.h"

namespace colmap_ext {

struct PairMatches {
  ImagePair pair;
  std::vector<KeypointMatch> matches;
};

// Matches the pairs by the descriptors of the database. Result i belongs to pair i.
std::vector<PairMatches> MatchImagePairs(const DatabaseView& database,
                                         const std::vector<ImagePair>& pairs,
                                         const MatchingOptions& options, const JobControl& job);

// Verifies the matches by `colmap matches_importer`, adds to the pairs that pass what matches along
// their epipolar lines (AddGuidedMatches), and stores all in the draft, in one transaction. COLMAP
// draws its random samples from one sequence for all pairs of a run, so the pairs are split into
// runs of a fixed size: the same result on every machine, and several runs at once. `work_path`
// gets the runs' temporary files.
void VerifyAndStore(const std::vector<PairMatches>& all_matches, const UpdateDatabase& databases,
                    const std::filesystem::path& work_path, const MatchingOptions& options,
                    ColmapProgram* colmap, const JobControl& job);

}  // namespace colmap_ext
