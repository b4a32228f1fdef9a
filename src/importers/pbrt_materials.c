/* pbrt's materials; docs/formats.md has the table. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "importers/pbrt.h"
#include "maths/functions.h"

static const double black[3] = {0, 0, 0}, half[3] = {0.5, 0.5, 0.5},
                    quarter[3] = {0.25, 0.25, 0.25};

/* ---- building ---- */

static void add(pbrt_material *m, snell_param param) {
    if (m->count < PBRT_PARAMS_MAX) m->list[m->count++] = param;
}
static void add_input(pbrt_material *m, const char *name, snell_input value) {
    m->textured |= value.texture.index1 != 0;
    add(m, (snell_param){name, SNELL_PARAM_INPUT, {.input = value}});
}
static void add_float(pbrt_material *m, const char *name, double value) {
    add(m, (snell_param){name, SNELL_PARAM_FLOAT, {.f = value}});
}
static void add_color(pbrt_material *m, const char *name, const double c[3]) {
    add(m, (snell_param){name, SNELL_PARAM_VEC3, {.v = {(float)c[0], (float)c[1], (float)c[2]}}});
}
static void add_reflectance(pbrt *p, const pbrt_params *params, const char *name,
                            const double otherwise[3], const char *into, double factor,
                            pbrt_material *m) {
    snell_input value;
    if (pbrt_input(p, params, name, false, otherwise, &value, NULL)) return;
    value.value = vec3_scale(value.value, (float)factor);
    add_input(m, into, value);
}

/* pbrt's alpha of GGX is the root of its roughness, unless it says not to remap; snell's alpha is its
 * roughness squared. prefix: "", or "conductor." and "interface.". */
static void add_roughness(pbrt *p, const pbrt_params *params, const char *prefix, const char *into,
                          pbrt_material *m) {
    char both[40], along[40], across[40];
    snprintf(both, sizeof both, "%sroughness", prefix);
    snprintf(along, sizeof along, "%suroughness", prefix);
    snprintf(across, sizeof across, "%svroughness", prefix);
    double power = pbrt_bool(p, params, "remaproughness", true) ? 0.25 : 0.5;
    snell_input u, v, value;
    bool has_u, has_v;
    if (pbrt_roughness_input(p, params, both, 0, power, &value, NULL) ||
        pbrt_roughness_input(p, params, along, 0, power, &u, &has_u) ||
        pbrt_roughness_input(p, params, across, 0, power, &v, &has_v))
        return;
    if (!has_u) u = value;
    if (!has_v) v = value;
    if (has_u || has_v) {
        value = u;
        if (memcmp(&u, &v, sizeof u) != 0)
            pbrt_warn(p, params->place, "anisotropic roughness is not supported: the mean is used");
        /* Of alphas: the geometric mean. */
        if (u.texture.index1 == 0 && v.texture.index1 == 0)
            value.value.x = (float)sqrt((double)u.value.x * (double)v.value.x);
    }
    value.value.x = float_min(value.value.x, 1);
    add_input(m, into, value);
}

/* ---- models ---- */

static void diffuse(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    m->type = "lambert";
    add_reflectance(p, params, "reflectance", half, "color", 1, m);
}

static void diffuse_transmission(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    double scale = pbrt_float(p, params, "scale", 1);
    m->type = "lambert";
    add_reflectance(p, params, "reflectance", quarter, "color", scale > 0 ? scale : 0, m);
    pbrt_warn(p, params->place,
              "diffuse transmission is not supported: 'diffusetransmission' only reflects");
    pbrt_ignore(params, "transmittance");
}

/* Light crosses the coat twice on its way, once bent and once diffusely: by Beer's law about three
 * thicknesses. */
static double coat_loss(pbrt *p, const pbrt_params *params) {
    static const double thin[3] = {0.01, 0.01, 0.01};
    snell_input given = {.value = {0.01f, 0.01f, 0.01f}};
    pbrt_input(p, params, "thickness", true, thin, &given, NULL);
    double thickness = given.texture.index1 ? thin[0] : (double)given.value.x;
    pbrt_ignore(params, "maxdepth nsamples");
    pbrt_lacks(p, params, "albedo g");
    return fn_exp(-3 * double_min(double_max(thickness, 0), 10));
}

static double clamped_index(double index) { return index < 1 ? 1 : index > 10 ? 10 : index; }

static void coated_diffuse(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    m->type = "ggx";
    double loss = coat_loss(p, params);
    add_reflectance(p, params, "reflectance", half, "color", loss, m);
    add_roughness(p, params, "", "roughness", m);
    add_float(m, "ior", clamped_index(pbrt_index(p, params, "eta", 1.5)));
}

static void dielectric(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    m->type = "dielectric";
    m->is_glass = true;
    double index = pbrt_index(p, params, "eta", 1.5);
    if (index < 1)
        pbrt_warn(p, params->place, "an index of refraction below 1 is not supported: 1 is used");
    add_float(m, "ior", clamped_index(index));
    add_roughness(p, params, "", "roughness", m);
}

/* A thin wall reflects R + T^2 R / (1 - R^2) = 2 R / (1 + R) at normal incidence; principled's has one
 * face, so its index is that of which a face reflects as much. */
static void thin_dielectric(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    double index = clamped_index(pbrt_index(p, params, "eta", 1.5));
    double root = (index - 1) / (index + 1), face = root * root;
    double both = sqrt(2 * face / (1 + face));
    m->type = "principled";
    const double white[3] = {1, 1, 1};
    add_color(m, "base_color", white);
    add_float(m, "transmission", 1);
    add_float(m, "roughness", 0);
    add_float(m, "ior", clamped_index((1 + both) / (1 - both)));
}

/* eta and k for red, green and blue, of copper where the file says nothing; false: a reflectance was
 * given instead. */
static bool read_metal(pbrt *p, const pbrt_params *params, const char *prefix, double eta[3],
                       double k[3]) {
    static const double copper_eta[3] = {0.140, 0.954, 1.215}, copper_k[3] = {3.261, 2.598, 2.369};
    char eta_name[24], k_name[24];
    snprintf(eta_name, sizeof eta_name, "%seta", prefix);
    snprintf(k_name, sizeof k_name, "%sk", prefix);
    pbrt_param *const given[2] = {pbrt_find(params, eta_name), pbrt_find(params, k_name)};
    memcpy(eta, copper_eta, sizeof copper_eta);
    memcpy(k, copper_k, sizeof copper_k);
    if (pbrt_find(params, "reflectance")) {
        if (given[0] || given[1])
            pbrt_fail(p, params->place, "leave one of them out",
                      "%s has both 'reflectance' and '%s' or '%s'", params->what, eta_name, k_name);
        return false;
    }
    double *const out[2] = {eta, k};
    for (int i = 0; i < 2 && !p->status; i++) {
        if (given[i] == NULL) continue;
        given[i]->used = true;
        if (strcmp(given[i]->type, "texture") == 0)
            pbrt_warn(p, given[i]->place,
                      "textures of a conductor's eta and k are not supported: copper's are used");
        else if (strcmp(given[i]->type, "float") == 0 && given[i]->count == 1)
            out[i][0] = out[i][1] = out[i][2] = given[i]->numbers[0];
        else
            pbrt_spectrum(p, given[i], PBRT_COEFFICIENT, out[i]);
    }
    for (int c = 0; c < 3; c++) {
        eta[c] = eta[c] < 0.001 ? 0.001 : eta[c] > 100 ? 100 : eta[c];
        k[c] = k[c] < 0 ? 0 : k[c] > 100 ? 100 : k[c];
    }
    return true;
}

static void conductor(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    double eta[3], k[3];
    if (read_metal(p, params, "", eta, k)) {
        m->type = "conductor";
        add_color(m, "eta", eta);
        add_color(m, "k", k);
    } else {
        m->type = "principled";
        add_reflectance(p, params, "reflectance", half, "base_color", 1, m);
        add_float(m, "metallic", 1);
    }
    add_roughness(p, params, "", "roughness", m);
}

/* The metal under the coat reflects as it does inside it. */
static void coated_conductor(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    double eta[3], k[3], seen[3],
        loss = coat_loss(p, params),
        index = clamped_index(pbrt_index(p, params, "interface.eta", 1.5));
    m->type = "principled";
    if (read_metal(p, params, "conductor.", eta, k)) {
        for (int c = 0; c < 3; c++) {
            double n = eta[c] / index, a = k[c] / index;
            seen[c] = loss * ((n - 1) * (n - 1) + a * a) / ((n + 1) * (n + 1) + a * a);
        }
        add_color(m, "base_color", seen);
    } else {
        add_reflectance(p, params, "reflectance", half, "base_color", loss, m);
    }
    add_float(m, "metallic", 1);
    add_float(m, "clearcoat", 1);
    add_roughness(p, params, "conductor.", "roughness", m);
    add_roughness(p, params, "interface.", "clearcoat_roughness", m);
    pbrt_warn(p, params->place, "'coatedconductor' is a metal under clear varnish of index 1.5");
}

/* Reduced scattering and absorption, 1/mm: Jensen et al., A Practical Model for Subsurface Light
 * Transport, SIGGRAPH 2001, figure 5. */
typedef struct scatterer {
    const char *name;
    double s[3], a[3];
} scatterer;
static const scatterer scatterers[] = {
    {"Apple", {2.29, 2.39, 1.97}, {0.0030, 0.0034, 0.046}},
    {"Chicken1", {0.15, 0.21, 0.38}, {0.015, 0.077, 0.19}},
    {"Chicken2", {0.19, 0.25, 0.32}, {0.018, 0.088, 0.20}},
    {"Cream", {7.38, 5.47, 3.15}, {0.0002, 0.0028, 0.0163}},
    {"Ketchup", {0.18, 0.07, 0.03}, {0.061, 0.97, 1.45}},
    {"Marble", {2.19, 2.62, 3.00}, {0.0021, 0.0041, 0.0071}},
    {"Potato", {0.68, 0.70, 0.55}, {0.0024, 0.0090, 0.12}},
    {"Skimmilk", {0.70, 1.22, 1.90}, {0.0014, 0.0025, 0.0142}},
    {"Skin1", {0.74, 0.88, 1.01}, {0.032, 0.17, 0.48}},
    {"Skin2", {1.09, 1.59, 1.79}, {0.013, 0.070, 0.145}},
    {"Spectralon", {11.6, 20.4, 14.9}, {0, 0, 0}},
    {"Wholemilk", {2.55, 3.21, 3.77}, {0.0011, 0.0024, 0.014}},
};

/* The diffuse reflectance of a half-space of index eta: the same paper, section 2.1. */
static double diffuse_albedo(double s, double a, double eta) {
    double total = s + a, albedo = total > 0 ? s / total : 0;
    double fresnel = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
    double edge = (1 + fresnel) / (1 - fresnel), root = sqrt(3 * (1 - albedo));
    return albedo / 2 * (1 + fn_exp(-4.0 / 3 * edge * root)) * fn_exp(-root);
}

/* What a thick piece reflects, where the light falls. */
static void subsurface(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    double s[3] = {2.55, 3.21, 3.77}, a[3] = {0.0011, 0.0024, 0.014}, color[3],
           eta = clamped_index(pbrt_index(p, params, "eta", 1.33));
    bool found;
    m->type = "ggx";
    pbrt_warn(p, params->place,
              "light that wanders under surfaces is not supported: 'subsurface' is a matte colour "
              "under a coat");
    const char *name = pbrt_string(p, params, "name", "");
    double g = clamp01(pbrt_float(p, params, "g", 0));
    pbrt_ignore(params, "mfp scale");
    if (p->status) return;
    if (name[0] == 0 && pbrt_find(params, "reflectance")) {
        add_reflectance(p, params, "reflectance", half, "color", 1, m);
    } else {
        size_t i = 0, count = sizeof scatterers / sizeof scatterers[0];
        while (i < count && strcmp(scatterers[i].name, name) != 0) i++;
        if (i < count) {
            memcpy(s, scatterers[i].s, sizeof s);
            memcpy(a, scatterers[i].a, sizeof a);
        } else if (name[0]) {
            pbrt_warn(p, params->place, "the scattering of '%.40s' is not known: whole milk", name);
        }
        for (int k = 0; k < 2; k++) {
            const pbrt_param *given = pbrt_find(params, k ? "sigma_s" : "sigma_a");
            if (given && strcmp(given->type, "texture") == 0)
                pbrt_lacks(p, params, k ? "sigma_s" : "sigma_a");
            else if (given)
                pbrt_color(p, params, k ? "sigma_s" : "sigma_a", PBRT_COEFFICIENT, k ? s : a,
                           k ? s : a, &found);
        }
        for (int c = 0; c < 3; c++) color[c] = diffuse_albedo(s[c] * (1 - g), a[c], eta);
        add_color(m, "color", color);
    }
    add_roughness(p, params, "", "roughness", m);
    add_float(m, "ior", eta);
}

static void hair(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    static const double brown[3] = {0.12, 0.06, 0.03};
    m->type = "lambert";
    pbrt_warn(p, params->place, "the material 'hair' is not supported: its colour, matte");
    const char *name = pbrt_find(params, "reflectance") ? "reflectance" : "color";
    add_reflectance(p, params, name, brown, "color", 1, m);
    pbrt_ignore(params, "sigma_a eumelanin pheomelanin eta beta_m beta_n alpha");
}

static void measured(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    m->type = "lambert";
    pbrt_warn(p, params->place, "measured materials are not supported: grey, matte");
    pbrt_ignore(params, "filename");
    add_reflectance(p, params, "reflectance", half, "color", 1, m);
}

static void nothing(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    (void)p, (void)params;
    m->type = NULL;
}

/* One of the two where snell cannot blend them. */
static void choose(pbrt *p, const pbrt_params *params, size_t part, pbrt_material *m) {
    const pbrt_material *only = &p->materials[part];
    m->type = only->type;
    m->count = only->count;
    m->textured = only->textured;
    m->is_glass = only->is_glass;
    memcpy(m->list, only->list, sizeof m->list);
    pbrt_warn(p, params->place,
              "a mix of glass, or of mixed materials, is not supported: the larger part is used");
}

static void mixed(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    static const snell_material_id none = {0, 0};
    pbrt_param *param = pbrt_find(params, "materials");
    size_t parts[2];
    snell_input amount;
    if (param == NULL || param->kind != PBRT_STRINGS || param->count != 2) {
        pbrt_fail(p, param ? param->place : params->place,
                  "such as \"string materials\" [ \"a\" \"b\" ]", "a mix needs two 'materials'");
        return;
    }
    param->used = true;
    for (int i = 0; i < 2; i++) {
        json_t *found = json_object_get(p->named_materials, param->strings[i]);
        if (found == NULL) {
            pbrt_fail(p, param->place, "it is made by MakeNamedMaterial, before it is used",
                      "no material is called '%.60s'", param->strings[i]);
            return;
        }
        parts[i] = (size_t)json_integer_value(found);
        if (p->materials[parts[i]].type == NULL) {
            pbrt_fail(p, param->place, NULL, "an 'interface' cannot be mixed");
            return;
        }
    }
    if (pbrt_input(p, params, "amount", true, half, &amount, NULL)) return;
    amount.value.x = float_min(amount.value.x, 1);
    const pbrt_material *a = &p->materials[parts[0]], *b = &p->materials[parts[1]];
    if (a->is_glass || b->is_glass || strcmp(a->type, "mix") == 0 || strcmp(b->type, "mix") == 0) {
        choose(p, params, parts[amount.value.x > 0.5f], m);
        return;
    }
    m->type = "mix";
    m->textured = a->textured || b->textured;
    pbrt_variant plain = {.alpha = {.value = {1, 1, 1}}};
    const char *const names[] = {"a", "b"};
    for (int i = 0; i < 2; i++) {
        uint32_t made;
        snell_param part = {names[i], SNELL_PARAM_MATERIAL, {.material = none}};
        if (pbrt_material_use(p, parts[i], &plain, &made)) return;
        part.value.material = (snell_material_id){made + 1, 0};
        add(m, part);
    }
    add_input(m, "weight", amount);
}

/* ---- what all have ---- */

/* Heights are metres along the normal; pictures of normals are linear, as snell's are. */
static void add_relief(pbrt *p, const pbrt_params *params, pbrt_material *m) {
    const pbrt_param *file = pbrt_find(params, "normalmap");
    const char *name = pbrt_string(p, params, "normalmap", "");
    bool found;
    snell_input height;
    if (!p->status && name[0]) {
        decoded_image image;
        pbrt_texture plain = {.scale = {1, 1}};
        snell_texture_id map = {0, 0};
        if (pbrt_read_image(p, name, file->place, &image, &found)) return;
        if (found) {
            pbrt_add_image(p, params->place, &image, false, &plain, &map);
            image_free(&image);
            add(m, (snell_param){"normal_map", SNELL_PARAM_TEXTURE, {.texture = map}});
            m->textured = true;
        }
    }
    if (pbrt_input(p, params, "displacement", true, black, &height, &found) || !found) return;
    add_input(m, "bump", height);
}

snell_status pbrt_material_add(pbrt *p, const char *name, const pbrt_params *params,
                               size_t *index) {
    static const struct {
        const char *name;
        void (*read)(pbrt *p, const pbrt_params *params, pbrt_material *m);
    } models[] = {{"diffuse", diffuse},
                  {"coateddiffuse", coated_diffuse},
                  {"coatedconductor", coated_conductor},
                  {"diffusetransmission", diffuse_transmission},
                  {"dielectric", dielectric},
                  {"thindielectric", thin_dielectric},
                  {"conductor", conductor},
                  {"subsurface", subsurface},
                  {"hair", hair},
                  {"measured", measured},
                  {"mix", mixed},
                  {"interface", nothing},
                  {"none", nothing},
                  {"", nothing}};
    size_t i = 0, count = sizeof models / sizeof models[0];
    const char *names[16];
    for (size_t k = 0; k < count; k++) names[k] = models[k].name;
    while (i < count && strcmp(models[i].name, params->type) != 0) i++;
    if (i == count) {
        char hint[80];
        const char *like = closest_word(params->type, names, count - 1);
        snprintf(hint, sizeof hint, "did you mean '%s'?", like ? like : "");
        return pbrt_fail(p, params->place, like ? hint : NULL, "unknown material '%s'",
                         params->type);
    }
    pbrt_material m = {.place = params->place, .first_variant = SIZE_MAX};
    models[i].read(p, params, &m);
    if (!p->status && m.type) add_relief(p, params, &m);
    pbrt_ignore(params, "type");
    if (p->status) return p->status;
    if (name && (m.name = memory_copy_string(name)) == NULL)
        return pbrt_blame(p, params->place, error_no_memory());
    if (!ARRAY_GROW(p->materials, p->material_count, p->material_capacity, 1)) {
        free(m.name);
        return pbrt_blame(p, params->place, error_no_memory());
    }
    *index = p->material_count;
    p->materials[p->material_count++] = m;
    return SNELL_OK;
}

/* ---- as a shape has it ---- */

static bool is_black(vec3 v) { return !(v.x > 0 || v.y > 0 || v.z > 0); }

static bool same(const pbrt_variant *a, const pbrt_variant *b) {
    return memcmp(&a->alpha, &b->alpha, sizeof a->alpha) == 0 &&
           memcmp(&a->emission, &b->emission, sizeof a->emission) == 0 &&
           memcmp(&a->absorption, &b->absorption, sizeof a->absorption) == 0 &&
           a->two_sided == b->two_sided;
}

static snell_status make_variant(pbrt *p, const pbrt_material *m, pbrt_variant *v) {
    snell_param list[PBRT_PARAMS_MAX + 4];
    size_t count = m->count;
    memcpy(list, m->list, count * sizeof *list);
    if (!is_black(v->emission)) {
        snell_input emission = {.value = v->emission};
        list[count++] = (snell_param){"emission", SNELL_PARAM_INPUT, {.input = emission}};
        list[count++] = (snell_param){"emit_two_sided", SNELL_PARAM_BOOL, {.b = v->two_sided}};
    }
    if (v->alpha.texture.index1 || v->alpha.value.x < 1)
        list[count++] = (snell_param){"alpha", SNELL_PARAM_INPUT, {.input = v->alpha}};
    if (m->is_glass && !is_black(v->absorption))
        list[count++] = (snell_param){"absorption", SNELL_PARAM_VEC3, {.v = v->absorption}};
    char name[NAME_MAX_SIZE];
    if (pbrt_blame(p, m->place, names_make_unique(&p->names, CATEGORY_MATERIAL, m->name, name)))
        return p->status;
    object_source source = {name[0] ? name : NULL, m->place.file, m->place.line};
    return pbrt_blame(
        p, m->place,
        description_add(p->d, CATEGORY_MATERIAL, m->type, list, count, source, &v->index));
}

snell_status pbrt_material_use(pbrt *p, size_t index, const pbrt_variant *with, uint32_t *out) {
    pbrt_material *m = &p->materials[index];
    pbrt_variant v = *with;
    size_t at = m->first_variant;
    while (at != SIZE_MAX && !same(&p->variants[at], with)) at = p->variants[at].next;
    if (at == SIZE_MAX) {
        if (make_variant(p, m, &v)) return p->status;
        if (!ARRAY_GROW(p->variants, p->variant_count, p->variant_capacity, 1))
            return pbrt_blame(p, m->place, error_no_memory());
        v.next = m->first_variant;
        at = m->first_variant = p->variant_count;
        p->variants[p->variant_count++] = v;
    }
    *out = p->variants[at].index;
    return SNELL_OK;
}
