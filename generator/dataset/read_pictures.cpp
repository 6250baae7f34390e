#include "dataset/read_pictures.h"
