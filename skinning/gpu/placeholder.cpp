namespace gelenk {}
