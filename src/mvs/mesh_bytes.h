// Meshes as bytes of files that only this program reads: little-endian, numbers as they lie in
// memory.
#pragma once

#include <ostream>
#include <vector>

#include "colmap_ext/mvs/fusion.h"
#include "colmap_ext/scene/view_mesh.h"
#include "scene/byte_reader.h"

namespace colmap_ext {

// Of numbers, arrays or fixed-size Eigen vectors: types without padding.
template <typename T>
void PutBytes(const std::vector<T>& values, std::ostream& out) {
  WriteBytes(out, std::uint64_t{values.size()});
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(values.size() * sizeof(T)));
}

template <typename T>
void TakeBytes(ByteReader* in, std::vector<T>* values) {
  values->resize(in->ReadCount(sizeof(T), "values"));
  in->Take(values->data(), values->size() * sizeof(T), "values");
}

inline void PutBytes(const ImageMesh& mesh, std::ostream& out) {
  PutBytes(mesh.vertices_px, out);
  PutBytes(mesh.triangles, out);
  PutBytes(mesh.neighbors, out);
  PutBytes(mesh.superpixel, out);
  PutBytes(mesh.mean_bgr, out);
  WriteBytes(out, mesh.num_superpixels);
}

inline void TakeBytes(ByteReader* in, ImageMesh* mesh) {
  TakeBytes(in, &mesh->vertices_px);
  TakeBytes(in, &mesh->triangles);
  TakeBytes(in, &mesh->neighbors);
  TakeBytes(in, &mesh->superpixel);
  TakeBytes(in, &mesh->mean_bgr);
  mesh->num_superpixels = in->Read<int>("superpixels");
}

inline void PutBytes(const FacetDepths& depths, std::ostream& out) {
  PutBytes(depths.inverse_depth, out);
  PutBytes(depths.supported, out);
}

inline void TakeBytes(ByteReader* in, FacetDepths* depths) {
  TakeBytes(in, &depths->inverse_depth);
  TakeBytes(in, &depths->supported);
}

}  // namespace colmap_ext
