/* The instances of the description and its groups, frozen: what is drawn, and the tree over it. */
#ifndef SNELL_SCENE_INSTANCES_H
#define SNELL_SCENE_INSTANCES_H

#include "scene/scene.h"

/* After materials, lights and the clock are frozen. */
snell_status scene_freeze_geometry(scene *s, const description *d, const scene_options *options,
                                   thread_pool *pool);

/* What shadow rays make of an instance: MASK_OPAQUE, MASK_FILTER or MASK_NO_SHADOW. */
uint32_t instance_mask(const scene *s, const scene_instance *at);

#endif
