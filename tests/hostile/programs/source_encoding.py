# -*- coding: nonsense -*-
