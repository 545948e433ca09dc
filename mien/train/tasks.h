#pragma once

#include <memory>
#include <string>

#include "mien/dataset/dataset.h"
#include "mien/headset/views_file.h"
#include "mien/sensor/rig.h"
#include "mien/synthetic/eyewear/eyewear_dataset.h"
#include "mien/synthetic/headset/headset_dataset.h"
#include "mien/synthetic/speech/speech_dataset.h"
#include "mien/train/task.h"

namespace mien::train {

/// Light of photo-reflective sensors to markers: models of eyewear::MarkerNetworkFile, of causal networks.
/// `rig`: text of the rig file, to be kept in the model. Errors: bad_usage (not a causal network; no
/// sequence as long as a window), mismatch (arrays that do not fit), out_of_range.
[[nodiscard]] Result<std::unique_ptr<Task>> make_marker_task(Recipe recipe, synthetic::LightDataset training,
                                                             synthetic::LightDataset validation,
                                                             std::string rig);

/// What a network of pictures finds, frame by frame, to the face: the memory of a headset::ViewsFile, at
/// kFrameRateHz. Its network of pictures stays as it is. The same files are read as for that network: each
/// donning as it is, mirrored, and as other mountings and cameras show it.
/// `views`: what finds. Errors: bad_usage (not a causal network; no donning as long as a window), mismatch
/// (films of another size or number of views), cancelled.
[[nodiscard]] Result<std::unique_ptr<Task>> make_memory_task(Recipe recipe,
                                                             const synthetic::HeadsetFilms& films,
                                                             headset::ViewsFile views, const sensor::Rig& rig,
                                                             const Progress& progress);

/// Sound to the mouth: models of speech::SpeechNetworkFile, of causal networks that take a step a block. One
/// window of six is of sounds that are no speech.
/// Errors: bad_usage (not a causal network; no sequence as long as a window), mismatch (arrays that do not
/// fit; a voice in both sets), out_of_range.
[[nodiscard]] Result<std::unique_ptr<Task>> make_speech_task(Recipe recipe, synthetic::SpeechDataset training,
                                                             synthetic::SpeechDataset validation);

/// Pictures of a headset's cameras to the face, moment by moment: models of headset::ViewsFile.
/// `rig`: whose cameras the films are of. Errors: bad_usage (not a network of pictures), mismatch (films of
/// another size or number of views).
[[nodiscard]] Result<std::unique_ptr<Task>> make_views_task(Recipe recipe, synthetic::HeadsetFilms films,
                                                            const sensor::Rig& rig, std::string rig_text);

/// Features of IMUs to blendshape weights: models of model::ModelFile, of either kind of network.
/// The data may be of virtual performers, of takes (Sequence::from_take) or of both; of both, the recipe's
/// share (kUsualTakesShare unless told) says how much of the windows, of the score, and of normalisation,
/// mean pose and covariance is of takes. `rig`: text of the rig file, to be kept in the model.
/// `one_person`: those takes that train and those that validate are of the same one, and results say so.
/// Errors: mismatch, out_of_range (data that do not fit, somebody in both sets, performers of unknown skin
/// where the recipe wants known ones); bad_usage (no sequence as long as a window, nobody to validate on).
[[nodiscard]] Result<std::unique_ptr<Task>> make_blendshape_task(Recipe recipe, dataset::Dataset training,
                                                                 dataset::Dataset validation, std::string rig,
                                                                 bool one_person = false);

}  // namespace mien::train
