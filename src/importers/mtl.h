/* MTL, the material libraries of OBJ (Wavefront, Advanced Visualizer, appendix B2, 1995), with the extension for
 * physically based materials (Pr, Pm, Ps, Pc, Pcr, norm). docs/formats.md has what becomes of it. */
#ifndef SNELL_IMPORTERS_MTL_H
#define SNELL_IMPORTERS_MTL_H

#include "importers/files.h"
#include "importers/names.h"

typedef struct mtl mtl;

/* base: the OBJ file, in whose folder libraries and pictures are looked for; both are borrowed. names: those of
 * objects of d. */
snell_status mtl_create(const char *base, const import_options *options, description *d,
                        name_set *names, mtl **out);
void mtl_destroy(mtl *m);

/* Reads the library `name`. SNELL_ERR_IO, not to be opened, is for the caller to say; other errors have their
 * place. */
snell_status mtl_read(mtl *m, const char *name);
/* The material of this name, of the first library that has it; MTL_NONE: there is none. */
#define MTL_NONE UINT32_MAX
uint32_t mtl_find(const mtl *m, const char *name);
size_t mtl_count(const mtl *m); /* of all libraries so far: materials are numbered from 0 */

/* Does it fill a body with glass, or shine? Each such needs a mesh of its own. */
bool mtl_is_apart(const mtl *m, uint32_t material);
/* Its number in the description, made when first asked for. size: the diagonal of the model in metres, by which bump
 * maps are measured. */
snell_status mtl_make(mtl *m, uint32_t material, double size, uint32_t *out);
/* One message that names what of the materials that were made is not used. */
snell_status mtl_warn_of_losses(mtl *m);

#endif
