/* What a user should know before a picture is made: what the chosen integrator leaves out. */
#ifndef SNELL_RENDER_NOTES_H
#define SNELL_RENDER_NOTES_H

#include "integrators/integrator.h"

/* Warnings to the log, each once: ambient light that `path` ignores, materials that give back more
 * light than they get, emitters whose light only rays find that happen to meet them. */
void render_notes(const description *d, const scene *s, const integrator *policy,
                  const log_sink *log);

#endif
