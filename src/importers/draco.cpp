#include "importers/draco.h"

#include <cmath>
#include <exception>
#include <memory>
#include <string>

#include <draco/compression/decode.h>
#include <draco/mesh/mesh.h>

struct draco_mesh {
    std::unique_ptr<draco::Mesh> mesh;
};

static std::string message;

const char *draco_open(const void *data, size_t size, draco_mesh **out) {
    try {
        draco::DecoderBuffer buffer;
        buffer.Init(static_cast<const char *>(data), size);
        draco::Decoder decoder;
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok()) {
            message = decoded.status().error_msg_string();
            return message.c_str();
        }
        *out = new draco_mesh{std::move(decoded).value()};
        return nullptr;
    } catch (const std::exception &) {
        return "it needs more memory than there is";
    }
}

void draco_close(draco_mesh *m) { delete m; }

size_t draco_point_count(const draco_mesh *m) { return m->mesh->num_points(); }

size_t draco_index_count(const draco_mesh *m) { return 3 * size_t(m->mesh->num_faces()); }

void draco_read_indices(const draco_mesh *m, uint32_t *out) {
    for (uint32_t i = 0; i < m->mesh->num_faces(); i++)
        for (size_t k = 0; k < 3; k++) *out++ = m->mesh->face(draco::FaceIndex(i))[k].value();
}

template <typename T>
static bool read(const draco_mesh *m, uint32_t id, unsigned components, bool normalized, T *out) {
    const draco::PointAttribute *stored = m->mesh->GetAttributeByUniqueId(id);
    if (stored == nullptr || unsigned(stored->num_components()) != components) return false;
    draco::GeometryAttribute attribute = *stored;
    attribute.set_normalized(normalized);
    for (uint32_t i = 0; i < m->mesh->num_points(); i++, out += components) {
        draco::AttributeValueIndex at = stored->mapped_index(draco::PointIndex(i));
        if (at.value() >= stored->size()) return false;
        if (!attribute.ConvertValue<T>(at, int8_t(components), out)) return false;
    }
    return true;
}

bool draco_read_floats(const draco_mesh *m, uint32_t id, unsigned components, bool normalized,
                       float *out) {
    if (!read<float>(m, id, components, normalized, out)) return false;
    for (size_t i = 0; i < components * draco_point_count(m); i++)
        if (!std::isfinite(out[i])) return false;
    return true;
}

bool draco_read_uints(const draco_mesh *m, uint32_t id, unsigned components, uint32_t *out) {
    return read<uint32_t>(m, id, components, false, out);
}
